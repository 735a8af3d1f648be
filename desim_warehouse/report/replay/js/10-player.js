// Time as the player keeps it, in ticks; 1x is real time.

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];

class Player {
  constructor(header, story) {
    const { tick, units } = header;
    this.span = Math.round((header.end - header.start) / tick);
    this.unit = 1 / tick; // ticks in a time unit
    this.perSecond = 1 / (tick * units.seconds);
    this.story = story;
    this.time = 0;
    this.playing = false;
    this.speed = this.fit();
    this.changed = () => {};
  }

  // The speed at which the window plays in about a minute.
  fit() {
    const wanted = this.span / this.perSecond / 60;
    return SPEEDS.find((speed) => speed >= wanted) ?? SPEEDS.at(-1);
  }

  advance(milliseconds) {
    if (!this.playing) return;
    this.time += (milliseconds / 1000) * this.perSecond * this.speed;
    if (this.time >= this.span) {
      this.time = this.span;
      this.playing = false;
      this.changed();
    }
  }

  seek(time) {
    this.time = Math.min(Math.max(time, 0), this.span);
    this.changed();
  }

  toggle() {
    if (!this.playing && this.time >= this.span) this.time = 0;
    this.playing = !this.playing;
    this.changed();
  }

  step(units) {
    this.playing = false;
    this.seek((Math.round(this.time / this.unit) + units) * this.unit);
  }

  faster(by) {
    const at = SPEEDS.indexOf(this.speed) + by;
    this.speed = SPEEDS[Math.min(Math.max(at, 0), SPEEDS.length - 1)];
    this.changed();
  }

  // The next (or previous) collision from here, by when it began; it is stood a moment into it. -1: none.
  collision(direction) {
    const { beginnings, byBegin, waitBegin, waitLength } = this.story;
    const inside = (wait) => Math.min(waitBegin[wait] + waitLength[wait] / 2, waitBegin[wait] + this.unit / 2);
    let at = lastBefore(beginnings, this.time) + (direction > 0 ? 1 : 0);
    while (at >= 0 && at < byBegin.length) {
      const wait = byBegin[at], moment = inside(wait);
      const beyond = direction > 0 ? moment > this.time : moment < this.time - 1e-6;
      if (beyond && moment >= 0 && moment <= this.span && waitLength[wait] > 0) {
        this.playing = false;
        this.seek(moment);
        return wait;
      }
      at += direction;
    }
    return -1;
  }

  rotation() {
    const next = this.story.rings.find((ring) => ring.time > this.time + 0.5);
    if (next === undefined) return null;
    this.playing = false;
    this.seek(next.time);
    return next;
  }
}
