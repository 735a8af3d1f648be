// The course of the run by the clock, drawn before the page was made: a line at the time shown, and a click goes to a time.

class Course {
  constructor(root, player) {
    this.root = root;
    this.player = player;
    for (const lanes of root.querySelectorAll(".lanes")) lanes.append(element("div", { class: "now" }));
    root.addEventListener("pointerdown", (event) => this.go(event));
    root.addEventListener("pointermove", (event) => event.buttons && this.go(event));
  }

  // To the time under the pointer; a drag goes on with it.
  go(event) {
    const plot = event.target.closest(".lanes")?.querySelector(".plot");
    if (!plot || event.button > 0) return;
    const { left, width } = plot.getBoundingClientRect(), part = (event.clientX - left) / width;
    if (part < 0 || part > 1) return;
    event.preventDefault();
    this.player.seek(this.player.start + part * (this.player.end - this.player.start));
  }

  show() {
    const { time, start, end } = this.player;
    this.root.style.setProperty("--at", (time - start) / (end - start));
  }
}
