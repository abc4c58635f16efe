"use strict";
(() => {
  const chart = document.getElementById("chart");
  if (!chart) return;
  const filter = document.getElementById("filter");
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
    document.getElementById("zoom").textContent = `${zoom}×`;
  };
  document.getElementById("in").addEventListener("click", () => show(2));
  document.getElementById("out").addEventListener("click", () => show(0.5));
  for (const control of document.querySelectorAll(".controls")) control.hidden = false;
})();
