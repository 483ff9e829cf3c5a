"use strict";
// Turns the drawing in space and sorts tables. No less-than signs and no ampersands: the page stays well-formed XML.
document.querySelectorAll(".space").forEach(function (box) {
  // the legend holds small drawings, too: the figure's own is meant
  var svg = box.querySelector("figure svg"), controls = box.querySelector(".controls"), json = box.querySelector("script");
  if (!svg) return;
  var d = JSON.parse(json.textContent), slider = controls.querySelector("input"), output = controls.querySelector("output");
  var iso = [45, 35.264], az = iso[0], el = iso[1], from = null, zoom = 1, scale = d.scale, centre = d.centre.slice();
  var length = svg.querySelector(".scalebars .path"), said = length ? [length.getAttribute("d"), length.nextElementSibling.getAttribute("x"), length.nextElementSibling.textContent] : null;
  var right, up;
  function project(p) {
    return [d.centre[0] + d.scale * (p[0] * right[0] + p[1] * right[1] + p[2] * right[2]),
            d.centre[1] - d.scale * (p[0] * up[0] + p[1] * up[1] + p[2] * up[2])];
  }
  function line(points) {
    var down = false;
    return points.map(function (p) {
      if (!p) { down = false; return ""; }
      var q = project(p), s = (down ? "L" : "M") + q[0].toFixed(1) + " " + q[1].toFixed(1);
      down = true;
      return s;
    }).join("");
  }
  function nice(most) {
    var power = Math.pow(10, Math.floor(Math.log10(most)));
    return [5, 2, 1].map(function (m) { return m * power; }).find(function (s) { return most >= s; });
  }
  function draw() {
    d.scale = scale * zoom;
    var a = az * Math.PI / 180, e = el * Math.PI / 180, gain = slider ? Number(slider.value) : 0;
    right = [-Math.sin(a), Math.cos(a), 0];
    up = [-Math.cos(a) * Math.sin(e), -Math.sin(a) * Math.sin(e), Math.cos(e)];
    if (slider) output.textContent = slider.value;
    svg.querySelectorAll("[data-line]").forEach(function (path) {
      var which = path.getAttribute("data-line");
      var points = which === "nominal" ? d.nominal : d.runs[Number(which)].map(function (p) {
        return p ? p[0].map(function (v, k) { return v + gain * p[1][k] / 1000; }) : null;
      });
      path.setAttribute("d", line(points));
    });
    svg.querySelectorAll("[data-at]").forEach(function (mark) {
      var p = JSON.parse(mark.getAttribute("data-at")).map(function (v, k) { return v - d.middle[k]; }), q = project(p);
      mark.setAttribute("transform", "translate(" + q[0].toFixed(1) + " " + q[1].toFixed(1) + ")");
      var text = mark.querySelector("text"), x = q[0] - d.centre[0], y = q[1] - d.centre[1], r = Math.hypot(x, y) || 1;
      if (text) { text.setAttribute("x", (24 * x / r).toFixed(1)); text.setAttribute("y", (24 * y / r + 4).toFixed(1)); }
    });
    var triad = svg.querySelector(".triad"), foot = triad.getAttribute("data-foot").split(",").map(Number);
    triad.querySelectorAll("line").forEach(function (axis, k) {
      var text = triad.querySelectorAll("text")[k], far = foot[2] + 11;
      axis.setAttribute("x2", foot[0] + foot[2] * right[k]);
      axis.setAttribute("y2", foot[1] - foot[2] * up[k]);
      text.setAttribute("x", foot[0] + far * right[k]);
      text.setAttribute("y", foot[1] - far * up[k] + 4);
    });
    if (length) {
      var mm = nice(110 / d.scale), far = 300 + mm * d.scale, name = length.nextElementSibling;
      length.setAttribute("d", zoom === 1 ? said[0] : "M300 428v8M300 432H" + far + "M" + far + " 428v8");
      name.setAttribute("x", zoom === 1 ? said[1] : far + 8);
      name.textContent = zoom === 1 ? said[2] : said[2].replace(/[0-9.,\u202f]+ mm/, mm + " mm");
    }
    var bar = svg.querySelector(".scalebars .error");
    if (!bar) return;
    var words = bar.nextElementSibling, shown = gain > 0;
    bar.style.display = words.style.display = shown ? "" : "none";
    if (shown) {
      var um = nice(110000 / (d.scale * gain)), w = um / 1000 * gain * d.scale;
      bar.setAttribute("d", "M300 452v8M300 456H" + (300 + w) + "M" + (300 + w) + " 452v8");
      words.setAttribute("x", 300 + w + 8);
      words.textContent = "error " + um + " µm";
    }
  }
  function magnify(factor) {
    zoom = Math.max(1, Math.min(60, zoom * factor));
    if (zoom === 1) d.centre = centre.slice();
    svg.classList.toggle("zoomed", zoom > 1);
    draw();
  }
  function shift(dx, dy) { d.centre = [d.centre[0] + dx, d.centre[1] + dy]; draw(); }
  function turn(da, de) { az += da; el = Math.max(-90, Math.min(90, el + de)); draw(); }
  controls.hidden = false;
  svg.setAttribute("tabindex", "0");
  svg.classList.add("turns");
  if (slider) slider.addEventListener("input", draw);
  controls.querySelector(".view").addEventListener("click", function () { az = iso[0]; el = iso[1]; magnify(0); });
  controls.querySelector(".nearer").addEventListener("click", function () { magnify(1.5); });
  controls.querySelector(".farther").addEventListener("click", function () { magnify(1 / 1.5); });
  svg.addEventListener("wheel", function (e) {
    if (!(e.ctrlKey || e.metaKey)) return;
    e.preventDefault();
    magnify(e.deltaY > 0 ? 0.8 : 1.25);
  }, { passive: false });
  svg.addEventListener("pointerdown", function (e) { from = [e.clientX, e.clientY]; svg.setPointerCapture(e.pointerId); });
  svg.addEventListener("pointermove", function (e) {
    if (!from) return;
    var ctm = svg.getScreenCTM();
    if (e.shiftKey ? zoom > 1 : false) shift((e.clientX - from[0]) / ctm.a, (e.clientY - from[1]) / ctm.d);
    else turn(0.5 * (from[0] - e.clientX), 0.5 * (e.clientY - from[1]));
    from = [e.clientX, e.clientY];
  });
  ["pointerup", "pointercancel"].forEach(function (n) { svg.addEventListener(n, function () { from = null; }); });
  svg.addEventListener("keydown", function (e) {
    var factor = { "+": 1.5, "=": 1.5, "-": 1 / 1.5, "0": 0 }[e.key];
    if (factor !== undefined) { e.preventDefault(); magnify(factor); }
    var step = { ArrowLeft: [5, 0], ArrowRight: [-5, 0], ArrowUp: [0, 5], ArrowDown: [0, -5] }[e.key];
    if (step) { e.preventDefault(); turn(step[0], step[1]); }
  });
});
// A click on a heading sorts its table; another one turns the order round.
document.querySelectorAll("main table").forEach(function (table) {
  var head = table.tHead, body = table.tBodies[0];
  if (!head || !body || head.rows.length !== 1 || head.querySelector("[colspan]") || 3 > body.rows.length) return;
  function value(row, k) {
    var text = row.cells[k] ? row.cells[k].textContent.trim() : "", n = parseFloat(text.replace(/\u2212/g, "-").replace(/[\u202f\u00a0 ](?=\d{3})/g, ""));
    return [n === n ? n : Infinity, text];
  }
  Array.prototype.forEach.call(head.rows[0].cells, function (cell, k) {
    cell.classList.add("sorts");
    cell.setAttribute("tabindex", "0");
    cell.setAttribute("title", "Sort by this column");
    function sort() {
      var down = cell.getAttribute("aria-sort") === "ascending";
      Array.prototype.forEach.call(head.rows[0].cells, function (c) { c.removeAttribute("aria-sort"); });
      cell.setAttribute("aria-sort", down ? "descending" : "ascending");
      Array.prototype.slice.call(body.rows).map(function (row) { return [value(row, k), row]; }).sort(function (a, b) {
        var x = a[0], y = b[0], order = x[0] === y[0] ? x[1].localeCompare(y[1]) : (x[0] > y[0] ? 1 : -1);
        return down ? -order : order;
      }).forEach(function (r) { body.appendChild(r[1]); });
    }
    cell.addEventListener("click", sort);
    cell.addEventListener("keydown", function (e) { if (e.key === "Enter" || e.key === " ") { e.preventDefault(); sort(); } });
  });
});
