// A run on the floor, over and over, with what the replay page is made of.

class Watch {
  constructor(colours) {
    this.colours = new Colours("safe", colours);
    this.still = matchMedia("(prefers-reduced-motion: reduce)");
    this.asked = false;
    new ResizeObserver(() => this.resized()).observe(byId("side-1"));
    document.addEventListener("visibilitychange", () => this.wake());
  }

  async show({ header, columns }) {
    this.side = new Side(header, await columnsOf(header.columns, columns), this.colours, byId("side-1"), "A");
    this.player = this.dark = null;
    byId("nofloor").hidden = true;
    this.resized();
  }

  resized() {
    if (!this.side) return;
    this.side.scene.stale = true;
    this.side.scene.resize();
    this.player ??= this.begin();
    this.draw();
    this.wake();
  }

  begin() {
    const player = new Player([this.side]);
    player.playing = !this.still.matches;
    this.last = 0;
    return player;
  }

  draw() {
    if (this.colours.dark !== this.dark) {
      this.dark = this.colours.dark;
      this.side.scene.stale = true;
      drawLegend(byId("signs"), this.colours.now, [this.side]);
    }
    this.side.scene.draw(this.player.in(this.side));
  }

  wake() {
    if (this.asked || !this.player || document.hidden || this.still.matches) return;
    this.asked = true;
    requestAnimationFrame((now) => {
      this.asked = false;
      this.player.advance(Math.min(now - (this.last || now), 100));
      this.last = now;
      if (!this.player.playing) this.player.toggle(); // from the beginning
      this.draw();
      this.wake();
    });
  }
}
