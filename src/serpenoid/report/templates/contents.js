"use strict";
(() => {  // the contents are the headings of the page
  const list = document.getElementById("contents");
  for (const [i, heading] of document.querySelectorAll("h2").entries()) {
    if (heading.closest("[hidden]")) continue;
    const link = document.createElement("a");
    heading.id ||= "section-" + i;
    link.setAttribute("href", "#".concat(heading.id)); link.textContent = heading.textContent;
    list.append(link);
  }
  list.hidden = !list.childElementCount;
  for (const box of document.querySelectorAll(".wide")) {  // say so where a table or figure goes on beyond the edge
    const hint = () => box.classList.toggle("more", box.scrollWidth > box.clientWidth + 1);
    new ResizeObserver(hint).observe(box); hint();
  }
})();
