// Time as the player keeps it, one clock for all runs: in the time unit of the first; 1x is real time.

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
const CROSSING = 8; // seconds in which a robot crosses the floor where one watches
const FRAMES = 60; // a second

class Player {
  constructor(sides) {
    this.sides = sides;
    const { units } = sides[0].header;
    this.unit = units.times;
    this.seconds = units.seconds;
    const own = (side, time) => (time * side.header.units.seconds) / this.seconds;
    this.start = Math.min(...sides.map((side) => own(side, side.header.start)));
    this.end = Math.max(...sides.map((side) => own(side, side.header.end)));
    this.time = Math.min(Math.max(own(sides[0], sides[0].header.begin), this.start), this.end);
    if (this.time >= this.end) this.time = this.start;
    this.whole = true; // until it is played, figures are those of the whole run
    this.playing = false;
    this.speed = this.watch();
    this.speeds = this.choices();
    this.changed = () => {};
  }

  // The time in a run's own ticks.
  in(side, time = this.time) {
    return side.local(time, this.seconds);
  }

  // The first and the last moment, for axes.
  ends() {
    const { day } = this.sides[0].header, long = (this.end - this.start) * this.seconds;
    const text = (time) => {
      const seconds = time * this.seconds + day + 0.01;
      if (day || this.end * this.seconds >= 7200) return `${two((seconds / 3600) % (day ? 24 : Infinity))}:${two((seconds / 60) % 60)}`;
      return this.seconds === 1 && long >= 600 ? `${Math.round(time / 60)} min` : `${shortNumber(time)} ${this.unit}`;
    };
    return (this.texts ??= [text(this.start), text(this.end)]);
  }

  // The speed at which the fastest robot crosses the floor in some seconds, and moves less than its size in a frame.
  watch() {
    const speeds = this.sides.map(({ header, view }) => {
      const { left, right, top, bottom } = view.bounds, wide = Math.max(right - left, bottom - top);
      const size = 2 * Math.max(...header.radii, wide / 400);
      return (Math.min(wide / CROSSING, size * FRAMES) / header.fastest) * header.units.seconds;
    });
    return Number(Math.min(...speeds).toPrecision(2));
  }

  // The speed at which the window plays in about a minute.
  day() {
    return Number((((this.end - this.start) * this.seconds) / 60).toPrecision(2));
  }

  // All speeds, with what those two are for.
  choices() {
    const words = new Map(SPEEDS.map((speed) => [speed, `${speed}×`]));
    if (this.day() > this.watch()) words.set(this.day(), `${this.day()}×, all in a minute`);
    words.set(this.watch(), `${this.watch()}×, watch`);
    return Array.from(words, ([speed, text]) => ({ speed, words: text })).sort((a, b) => a.speed - b.speed);
  }

  // Whether robots move so far in a frame that nobody can follow them.
  get blurs() {
    return this.playing && this.speed > 3 * this.watch();
  }

  advance(milliseconds) {
    if (!this.playing) return;
    this.whole = false;
    this.time += ((milliseconds / 1000) * this.speed) / this.seconds;
    if (this.time >= this.end) {
      this.time = this.end;
      this.playing = false;
      this.changed();
    }
  }

  seek(time) {
    this.whole = false;
    this.time = Math.min(Math.max(time, this.start), this.end);
    this.changed();
  }

  toggle() {
    if (!this.playing && this.time >= this.end) this.time = this.start;
    this.playing = !this.playing;
    this.changed();
  }

  step(units) {
    this.playing = false;
    this.seek(Math.round(this.time) + units);
  }

  faster(by) {
    const at = this.speeds.findIndex(({ speed }) => speed === this.speed) + by;
    this.speed = this.speeds[Math.min(Math.max(at, 0), this.speeds.length - 1)].speed;
    this.changed();
  }

  stop(time) {
    this.playing = false;
    this.seek(time);
  }

  // The end, with the figures of the whole run.
  rest() {
    this.stop(this.end);
    this.whole = true;
    this.changed();
  }
}
