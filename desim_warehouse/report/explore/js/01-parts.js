// Parts of a page.

const byId = (id) => document.getElementById(id);

// An element with its attributes and what is in it: texts (never HTML) and other elements.
function part(tag, attributes = {}, ...inside) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...inside);
  return made;
}

function shape(tag, attributes = {}, text = null) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== null) made.textContent = text;
  return made;
}

// A copy of a list in which one item is another.
const changedAt = (list, rank, item) => list.map((was, at) => (at === rank ? item : was));

const letter = (side) => part("span", { class: `letter ${side}` }, side.toUpperCase());
