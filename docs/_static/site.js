// What scrolls sideways is reached by the keyboard, and captions of the sidebar say that they are headings of what level.
function reached() {
  for (const one of document.querySelectorAll("pre, .table-wrapper, article p")) {
    if (one.scrollWidth > one.clientWidth) one.tabIndex = 0;
  }
}
addEventListener("load", () => {
  for (const one of document.querySelectorAll("p[role=heading]")) one.setAttribute("aria-level", "2");
  reached();
});
addEventListener("resize", reached);
