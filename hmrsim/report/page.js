"use strict";
for (const chart of document.querySelectorAll(".chart")) {
  const section = chart.closest("section");
  const filter = section.querySelector("input");
  const rows = [...chart.querySelectorAll(".row")];
  filter.addEventListener("input", () => {
    const wanted = filter.value.trim().toLowerCase();
    for (const row of rows) row.hidden = !row.textContent.toLowerCase().includes(wanted);
  });
  let zoom = 1;
  const show = (factor) => {
    const names = chart.querySelector(".name").offsetWidth;
    const middle = (chart.scrollLeft + (chart.clientWidth - names) / 2) / zoom;
    zoom = Math.min(64, Math.max(1, zoom * factor));
    chart.style.setProperty("--zoom", zoom);
    chart.scrollLeft = middle * zoom - (chart.clientWidth - names) / 2;
    section.querySelector("output").textContent = `${zoom}×`;
  };
  for (const button of section.querySelectorAll("[data-zoom]")) {
    button.addEventListener("click", () => show(Number(button.dataset.zoom)));
  }
  for (const control of section.querySelectorAll(".controls")) control.hidden = false;
}
