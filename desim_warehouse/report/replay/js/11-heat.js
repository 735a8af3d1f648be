// How long robots waited where: the time lost where they stood, at the end of a lane, as a part of the time counted so far,
// from the start of the window, or from the end of the warm-up if that is later; kept up as time goes on.

class Heat {
  constructor(story, edges, steps) {
    this.story = story;
    this.steps = steps;
    this.lost = new Float64Array(edges.real); // ticks, by the edge on which they stood
    this.used = []; // edges with waits
    this.next = 0;
  }

  // The time lost in the waits that are over.
  upTo(time) {
    const { waitTime, waitBegin, waitEdge, from } = this.story;
    if (this.next > 0 && waitTime[this.next - 1] > time) {
      this.lost.fill(0);
      this.used.length = this.next = 0;
    }
    for (; this.next < waitTime.length && waitTime[this.next] <= time; this.next++) {
      const edge = waitEdge[this.next], lasted = waitTime[this.next] - Math.max(waitBegin[this.next], from);
      if (edge < 0 || lasted <= 0) continue;
      if (this.lost[edge] === 0) this.used.push(edge);
      this.lost[edge] += lasted;
    }
    return this.lost;
  }

  // The part of the time so far in which somebody waited at the end of an edge.
  share(edge, time) {
    const counted = time - this.story.from;
    return counted > 0 ? this.upTo(time)[edge] / counted : 0;
  }

  // Edges by step of the scale, which is the same for all floors.
  shaded(time) {
    this.upTo(time);
    const groups = [...this.steps, Infinity].map(() => []);
    for (const edge of this.used) {
      const share = this.share(edge, time), step = this.steps.findIndex((most) => share < most);
      groups[step < 0 ? this.steps.length : step].push(edge);
    }
    return groups;
  }
}
