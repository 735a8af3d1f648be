// The study: which design has which levels. Nothing is worked out here but ranks.

class Study {
  constructor(content) {
    Object.assign(this, content);
    this.rank = new Map(this.designs.map((design, rank) => [design.levels.join(), rank]));
  }

  at(levels) {
    return this.rank.get(levels.join());
  }

  // The designs with these levels but for one factor, in the order of its levels.
  along(levels, factor) {
    return this.factors[factor].levels.map((_, level) => this.at(changedAt(levels, factor, level)));
  }

  // The levels of a design, all or but for one factor: "Number of robots 3, Routing fastest".
  words(levels, without = -1) {
    const said = this.factors.map(({ head, levels: texts }, rank) => `${head.replace(/ \([^)]*\)$/, "")} ${texts[levels[rank]]}`);
    return said.filter((_, rank) => rank !== without).join(", ");
  }

  // Mean as text, and what is wrong there, for whoever points at it.
  said(indicator, design) {
    const mean = this.means[indicator][design], { wrong, error } = this.designs[design];
    return [this.words(this.designs[design].levels), mean ? mean[3] : error ?? "no value", ...wrong].join("\n");
  }
}
