// Mouse, pen and fingers on the floor: move it, zoom it, point at things, click a robot to see its panel.

class Pointer {
  constructor(app, side, canvas) {
    this.app = app;
    this.side = side;
    this.canvas = canvas;
    this.down = new Map();
    this.travelled = 0;
    const on = (kind, act, options) => canvas.addEventListener(kind, act, options);
    on("pointerdown", (event) => this.press(event));
    on("pointermove", (event) => this.move(event));
    on("pointerup", (event) => this.lift(event));
    on("pointercancel", (event) => this.lift(event, true));
    on("pointerleave", () => side.hover.hide());
    on("wheel", (event) => this.wheel(event), { passive: false });
    on("dblclick", (event) => app.controls.zoom(2, side, ...this.at(event)));
  }

  at(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  press(event) {
    this.down.set(event.pointerId, this.at(event));
    this.travelled = this.down.size > 1 ? Infinity : 0;
    this.canvas.setPointerCapture(event.pointerId);
    this.canvas.classList.add("moving");
  }

  move(event) {
    const now = this.at(event), before = this.down.get(event.pointerId);
    if (!before) return this.side.hover.show(...now);
    const others = [...this.down.entries()].filter(([id]) => id !== event.pointerId);
    this.down.set(event.pointerId, now);
    this.travelled += Math.hypot(now[0] - before[0], now[1] - before[1]);
    if (others.length) this.pinch(others[0][1], before, now);
    else if (this.travelled > 4) this.app.controls.pan(this.side, now[0] - before[0], now[1] - before[1]);
    this.side.hover.hide();
  }

  // Two fingers: the point between them stays between them.
  pinch(other, before, now) {
    const wide = (a) => Math.hypot(a[0] - other[0], a[1] - other[1]) || 1;
    this.app.controls.pan(this.side, (now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
    this.app.controls.zoom(wide(now) / wide(before), this.side, (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
  }

  lift(event, cancelled = false) {
    this.down.delete(event.pointerId);
    if (!this.down.size) this.canvas.classList.remove("moving");
    if (cancelled || this.travelled > 4) return;
    this.app.controls.pin(this.side, this.side.hover.whoAt(...this.at(event)));
    if (event.pointerType !== "mouse") this.side.hover.show(...this.at(event));
  }

  wheel(event) {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 30 : 1;
    this.app.controls.zoom(Math.exp(-event.deltaY * lines * 0.0015), this.side, ...this.at(event));
  }
}
