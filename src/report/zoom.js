"use strict";
// Zooms the charts and the other drawings. No less-than signs and no ampersands: the page stays well-formed XML.
// A drag across a chart shows that stretch of x, a double click a third of it or all of it again; so do keys and Ctrl with the wheel.
// Charts of one section that share their x move together.
var charts = [];
// One button below a figure, seen only where something is hidden by the zoom.
function allButton(svg, back) {
  var button = document.createElement("button");
  button.type = "button";
  button.className = "whole";
  button.textContent = "Show all";
  button.hidden = true;
  button.addEventListener("click", back);
  svg.parentNode.insertBefore(button, svg.nextSibling);
  return button;
}
// The place of a pointer in the drawing's own pixels.
function inside(svg, e) {
  var ctm = svg.getScreenCTM();
  return ctm ? new DOMPoint(e.clientX, e.clientY).matrixTransform(ctm.inverse()) : null;
}
// What a key asks for: a factor of the zoom, a shift in windows, or all.
function asked(key) {
  return { "+": [0.5, 0], "=": [0.5, 0], "-": [2, 0], ArrowLeft: [1, -0.25], ArrowRight: [1, 0.25], "0": [Infinity, 0], Escape: [Infinity, 0] }[key];
}
function chart(svg, plane) {
  var ns = svg.namespaceURI, n = plane.getAttribute("data-plane").split(" ").map(Number);
  var all = [n[0], n[1]], left = n[2], right = n[3], floor = n[6], top = n[7], from = null, fresh = [];
  var self = { svg: svg, all: all, window: all, section: svg.closest("section"), show: show, plane: n };
  var clip = document.createElementNS(ns, "clipPath"), room = document.createElementNS(ns, "rect"), content = document.createElementNS(ns, "g");
  var box = document.createElementNS(ns, "rect"), button = allButton(svg, function () { together(all); });
  function put(node, values) { Object.keys(values).forEach(function (k) { node.setAttribute(k, values[k]); }); return node; }
  clip.id = "chart" + charts.length;
  put(room, { x: left - 1, y: 0, width: right - left + 2, height: svg.viewBox.baseVal.height });
  clip.appendChild(room);
  while (plane.nextSibling) content.appendChild(plane.nextSibling);
  svg.appendChild(clip);
  svg.appendChild(content);
  svg.appendChild(put(box, { "class": "choice", y: top, height: Math.max(0, floor - top) }));
  box.style.display = "none";
  var parts = [];
  (function gather(node) {
    Array.prototype.forEach.call(node.children, function (e) {
      var whole = e.tagName === "text" || e.tagName === "circle" || e.classList.contains("mean") || e.classList.contains("mark") || e.classList.contains("glyph");
      if (e.tagName === "title") return;
      if (whole ? e.tagName !== "line" : false) parts.push([e, e.tagName === "text" ? Number(e.getAttribute("x")) : null]);
      else if (e.tagName === "g") gather(e);
      else parts.push([e]);
    });
  })(content);
  var ticks = [];
  for (var e = plane.previousElementSibling; e; e = e.previousElementSibling) {
    if (e.classList.contains("tick") ? e.getAttribute("text-anchor") === "middle" : e.classList.contains("axis") ? e.getAttribute("x1") === e.getAttribute("x2") : false) ticks.push(e);
  }
  function nice(rough) {
    var power = Math.pow(10, Math.floor(Math.log10(rough)));
    return [1, 2, 5, 10].map(function (m) { return m * power; }).find(function (s) { return s >= 0.75 * rough; });
  }
  function relabel(lo, hi) {
    fresh.forEach(function (e) { e.remove(); });
    fresh = [];
    var whole = self.window === all, step = nice((hi - lo) / (right - left > 380 ? 8 : 5)), decimals = Math.max(0, Math.min(9, -Math.floor(Math.log10(step * 1.0001))));
    ticks.forEach(function (e) { e.style.display = whole ? "" : "none"; });
    if (whole) return;
    for (var k = Math.ceil(lo / step - 1e-6); hi / step + 1e-6 >= k; k += 1) {
      var at = left + (k * step - lo) / (hi - lo) * (right - left), text = document.createElementNS(ns, "text");
      text.textContent = (k * step).toFixed(decimals).replace("-", "\u2212");
      fresh.push(put(document.createElementNS(ns, "line"), { "class": "axis", x1: at, x2: at, y1: floor, y2: floor + 4 }));
      fresh.push(put(text, { "class": "tick", x: at, y: floor + 17, "text-anchor": "middle" }));
    }
    fresh.forEach(function (e) { svg.insertBefore(e, plane); });
  }
  function show(range) {
    var lo = Math.max(all[0], range[0]), hi = Math.min(all[1], range[1]);
    if (!(hi - lo > 1e-5 * (all[1] - all[0]))) return;
    self.window = hi - lo > 0.999 * (all[1] - all[0]) ? all : [lo, hi];
    var zoomed = self.window !== all, s = (all[1] - all[0]) / (hi - lo), shift = left - s * (left + (lo - all[0]) / (all[1] - all[0]) * (right - left));
    n[0] = self.window[0];
    n[1] = self.window[1];
    parts.forEach(function (p) {
      var e = p[0];
      if (p.length > 1) {
        if (p[1] === null) { var b = e.getBBox(); p[1] = b.x + b.width / 2; }
        var to = s * p[1] + shift;
        // words of what lies outside would be cut
        e.style.display = zoomed ? (left - 1 > to || to > right + 1 ? "none" : "") : "";
        if (zoomed) e.setAttribute("transform", "translate(" + (to - p[1]) + " 0)");
      } else if (zoomed) {
        e.setAttribute("transform", "matrix(" + s + " 0 0 1 " + shift + " 0)");
        e.setAttribute("vector-effect", "non-scaling-stroke");
      }
      if (!zoomed) e.removeAttribute("transform");
    });
    if (zoomed) content.setAttribute("clip-path", "url(#" + clip.id + ")"); else content.removeAttribute("clip-path");
    button.hidden = !zoomed;
    relabel(n[0], n[1]);
  }
  function together(range) {
    charts.forEach(function (c) {
      if (c === self ? true : c.section === self.section ? c.all.join() === all.join() : false) c.show(range === all ? c.all : range);
    });
  }
  function value(x) { return n[0] + (Math.max(left, Math.min(right, x)) - left) / (right - left) * (n[1] - n[0]); }
  function scaled(factor, about, moved) {
    if (factor === Infinity) return together(all);
    var width = Math.min((n[1] - n[0]) * factor, all[1] - all[0]), lo = about - (about - n[0]) * width / (n[1] - n[0]) + moved * width;
    lo = Math.max(all[0], Math.min(all[1] - width, lo));
    together([lo, lo + width]);
  }
  svg.setAttribute("tabindex", "0");
  svg.classList.add("zooms");
  svg.addEventListener("pointerdown", function (e) {
    var at = inside(svg, e);
    if (!at || e.button !== 0 || e.pointerType === "touch" || left > at.x || at.x > right) return;
    from = at.x;
    svg.setPointerCapture(e.pointerId);
  });
  svg.addEventListener("pointermove", function (e) {
    var at = from === null ? null : inside(svg, e);
    if (!at) return;
    var to = Math.max(left, Math.min(right, at.x));
    put(box, { x: Math.min(from, to), width: Math.abs(to - from) });
    box.style.display = Math.abs(to - from) > 6 ? "" : "none";
  });
  svg.addEventListener("pointerup", function (e) {
    var at = from === null ? null : inside(svg, e), start = from;
    from = null;
    box.style.display = "none";
    if (!at || 6 >= Math.abs(at.x - start)) return;
    var ends = [value(start), value(at.x)];
    together([Math.min(ends[0], ends[1]), Math.max(ends[0], ends[1])]);
  });
  svg.addEventListener("pointercancel", function () { from = null; box.style.display = "none"; });
  svg.addEventListener("dblclick", function (e) {
    var at = inside(svg, e);
    if (self.window !== all) together(all);
    else if (at) scaled(1 / 3, value(at.x), 0);
  });
  svg.addEventListener("wheel", function (e) {
    var at = e.ctrlKey || e.metaKey ? inside(svg, e) : null;
    if (!at) return;
    e.preventDefault();
    scaled(e.deltaY > 0 ? 1.25 : 0.8, value(at.x), 0);
  }, { passive: false });
  svg.addEventListener("keydown", function (e) {
    var step = asked(e.key);
    if (!step || e.ctrlKey || e.metaKey) return;
    e.preventDefault();
    scaled(step[0], 0.5 * (n[0] + n[1]), step[1]);
  });
  charts.push(self);
  return self;
}
// Drawings without a plane (around the circle, along the path) are seen through a smaller window.
function magnifier(svg) {
  var all = svg.viewBox.baseVal, whole = [all.x, all.y, all.width, all.height], now = whole, from = null;
  var button = allButton(svg, function () { show(whole); });
  function show(v) {
    var w = Math.max(whole[2] / 40, Math.min(whole[2], v[2])), h = w * whole[3] / whole[2];
    now = [Math.max(whole[0], Math.min(whole[0] + whole[2] - w, v[0])), Math.max(whole[1], Math.min(whole[1] + whole[3] - h, v[1])), w, h];
    svg.setAttribute("viewBox", now.join(" "));
    button.hidden = w >= 0.999 * whole[2];
    svg.classList.toggle("zoomed", !button.hidden);
  }
  function scaled(factor, at) {
    if (factor === Infinity) return show(whole);
    show([at.x - (at.x - now[0]) * factor, at.y - (at.y - now[1]) * factor, now[2] * factor]);
  }
  svg.setAttribute("tabindex", "0");
  svg.addEventListener("dblclick", function (e) {
    var at = inside(svg, e);
    if (at) scaled(button.hidden ? 1 / 3 : Infinity, at);
  });
  svg.addEventListener("wheel", function (e) {
    var at = e.ctrlKey || e.metaKey ? inside(svg, e) : null;
    if (!at) return;
    e.preventDefault();
    scaled(e.deltaY > 0 ? 1.25 : 0.8, at);
  }, { passive: false });
  svg.addEventListener("pointerdown", function (e) { if (!button.hidden) { from = inside(svg, e); svg.setPointerCapture(e.pointerId); } });
  svg.addEventListener("pointermove", function (e) {
    var at = from ? inside(svg, e) : null;
    if (at) show([now[0] + from.x - at.x, now[1] + from.y - at.y, now[2]]);
  });
  ["pointerup", "pointercancel"].forEach(function (n) { svg.addEventListener(n, function () { from = null; }); });
  svg.addEventListener("keydown", function (e) {
    var step = asked(e.key);
    if (!step || e.ctrlKey || e.metaKey) return;
    e.preventDefault();
    if (step[1]) show([now[0] + step[1] * now[2], now[1], now[2]]);
    else scaled(step[0], { x: now[0] + now[2] / 2, y: now[1] + now[3] / 2 });
  });
}
document.querySelectorAll("main figure svg").forEach(function (svg) {
  var plane = svg.querySelector("[data-plane]");
  if (svg.closest(".space") || svg.closest("figcaption") || svg.closest(".legend")) return;
  if (plane) readout(chart(svg, plane)); else magnifier(svg);
});
// The value under the pointer, in the units of the axes.
function readout(chart) {
  var svg = chart.svg, p = chart.plane, ns = svg.namespaceURI;
  var line = document.createElementNS(ns, "line"), text = document.createElementNS(ns, "text");
  line.setAttribute("class", "cursor");
  text.setAttribute("class", "readout");
  line.style.display = text.style.display = "none";
  svg.appendChild(line);
  svg.appendChild(text);
  function written(v, span) { return v.toFixed(Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(span))))); }
  svg.addEventListener("pointerdown", hide);
  function hide() { line.style.display = text.style.display = "none"; }
  svg.addEventListener("pointerleave", hide);
  svg.addEventListener("pointermove", function (e) {
    var at = inside(svg, e);
    if (!at || e.buttons || p[2] > at.x || at.x > p[3] || p[7] > at.y || at.y > p[6]) { hide(); return; }
    var x = p[0] + (at.x - p[2]) / (p[3] - p[2]) * (p[1] - p[0]), y = p[4] + (at.y - p[6]) / (p[7] - p[6]) * (p[5] - p[4]);
    [["x1", at.x], ["x2", at.x], ["y1", p[6]], ["y2", p[7]]].forEach(function (a) { line.setAttribute(a[0], a[1]); });
    text.textContent = written(x, p[1] - p[0]) + ", " + written(y, p[5] - p[4]);
    var right = at.x > 0.5 * (p[2] + p[3]);
    text.setAttribute("text-anchor", right ? "end" : "start");
    text.setAttribute("x", at.x + (right ? -6 : 6));
    text.setAttribute("y", Math.max(at.y - 6, p[7] + 10));
    line.style.display = text.style.display = "";
  });
}
