// Parts of the what-if page.

function shape(tag, attributes = {}, text = null) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== null) made.textContent = text;
  return made;
}

// A copy of a list in which one item is another.
const changedAt = (list, rank, item) => list.map((was, at) => (at === rank ? item : was));

const letter = (side) => element("span", { class: `letter ${side}` }, side.toUpperCase());
