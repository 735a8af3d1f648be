// What holds a warehouse up: parts, each with its share of the time, and that in words; what holds most up first.

const PARTS = { robots: "Robots", traffic: "Waiting in traffic", chargers: "Chargers", stations: "Packers" };

function heldUp([part, share, said]) {
  const [mean] = said.split(" ("), who = PARTS[part].toLowerCase();
  if (part === "traffic") return `Traffic: robots wait in it ${mean} of the time, longer than they are busy.`;
  return share >= 0.8 ? `The ${who}: ${mean} busy.` : `Nothing: even the ${who} are free ${Math.round(100 * (1 - share))} % of the time.`;
}
