// Parts of any page.

const byId = (id) => document.getElementById(id);

// An element with its attributes and what is in it: texts (never HTML) and other elements.
function element(tag, attributes = {}, ...inside) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...inside);
  return made;
}
