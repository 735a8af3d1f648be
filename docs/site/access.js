// What the theme leaves out for readers who use the keyboard or a screen reader.
document.querySelector(".md-search").setAttribute("aria-label", "Search");
addEventListener("load", () => {
  for (const wide of document.querySelectorAll(".md-typeset pre, .md-typeset__scrollwrap")) wide.tabIndex = 0;
});
