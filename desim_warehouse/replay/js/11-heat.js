// How long robots waited where: the time lost where they stood, at the end of a lane, as a part of the time counted in the
// window, from the end of the warm-up on.

class Heat {
  constructor(story, edges, steps, span) {
    const { waitTime, waitBegin, waitEdge, from } = story, counted = span - from;
    this.shares = new Float64Array(edges.real); // by the edge on which they stood
    for (let i = 0; i < waitTime.length; i++) {
      const lasted = Math.min(waitTime[i], span) - Math.max(waitBegin[i], from);
      if (waitEdge[i] >= 0 && lasted > 0 && counted > 0) this.shares[waitEdge[i]] += lasted / counted;
    }
    this.shaded = steps.map(() => []); // edges by step of the scale, which is the same for all floors
    this.shares.forEach((share, edge) => {
      const step = steps.findLastIndex((least) => share >= least);
      if (step >= 0) this.shaded[step].push(edge);
    });
  }
}
