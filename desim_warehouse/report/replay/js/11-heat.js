// Waits in traffic an hour on each lane, counted from the start of the window, or from the end of the warm-up if that is
// later; kept up as time goes on.

class Heat {
  constructor(story, edges) {
    this.story = story;
    this.edges = edges;
    this.count = new Int32Array(edges.real);
    this.used = []; // lanes with waits
    this.next = 0;
    this.most = 0;
  }

  // The waits so far.
  upTo(time) {
    const { waitTime, waitEdge, from } = this.story;
    if (this.next > 0 && waitTime[this.next - 1] > time) {
      this.count.fill(0);
      this.used.length = this.next = this.most = 0;
    }
    for (; this.next < waitTime.length && waitTime[this.next] <= time; this.next++) {
      const edge = waitEdge[this.next];
      if (edge < 0 || waitTime[this.next] < from - 1e-9) continue;
      const lane = this.edges.lane(edge);
      if (this.count[lane]++ === 0) this.used.push(lane);
      this.most = Math.max(this.most, this.count[lane]);
    }
    return this.count;
  }

  hours(time) {
    const { tick, units } = this.story.header;
    return ((time - this.story.from) * tick * units.seconds) / 3600;
  }

  // Waits an hour so far on the lane of an edge.
  anHour(edge, time) {
    const hours = this.hours(time);
    return hours > 0 ? this.upTo(time)[this.edges.lane(edge)] / hours : 0;
  }

  // The most of any lane.
  mostAnHour(time) {
    const hours = this.hours(time);
    this.upTo(time);
    return hours > 0 ? this.most / hours : 0;
  }

  // Lanes by shade, those with the most waits last.
  shaded(time, shades) {
    this.upTo(time);
    const groups = Array.from({ length: shades }, () => []);
    for (const lane of this.used)
      groups[Math.min(Math.floor((this.count[lane] / this.most) * shades), shades - 1)].push(lane);
    return groups;
  }
}
