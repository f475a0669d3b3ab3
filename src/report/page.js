"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const tip = document.getElementById("tip");
  const NS = "http://www.w3.org/2000/svg";
  const num = (v, d) => (v === null || v === undefined ? "–" : v.toFixed(d).replace(/^-(?=0(\.0*)?$)/, "").replace("-", "−"));
  const make = (name, attributes, parent, text) => {
    const node = document.createElementNS(NS, name);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    if (text !== undefined) node.textContent = text;
    parent.appendChild(node);
    return node;
  };

  // ── values under the pointer ──
  const STATUS = { m: "measured", i: "interpolated", e: "extrapolated", u: "unreachable" };
  const show = (text, event) => {
    tip.textContent = text;
    tip.hidden = false;
    const box = tip.getBoundingClientRect();
    const x = event.clientX + 16, y = event.clientY + 16;
    tip.style.left = Math.max(4, Math.min(x, innerWidth - box.width - 8)) + "px";
    tip.style.top = (y + box.height > innerHeight ? event.clientY - box.height - 12 : y) + "px";
  };
  const hide = () => { tip.hidden = true; };
  const describe = (heat, a, b) => {
    const decimals = breaks => Math.min(4, Math.max(...breaks.map(v => (String(Math.round(v * 1e4) / 1e4).split(".")[1] || "").length)));
    const lines = [heat.x, heat.y].map((axis, k) => `${axis.n} ${num(axis.b[k ? b : a], decimals(axis.b))} ${axis.u}`);
    heat.v.forEach((field, k) => {
      const value = field.z[b][a];
      if (value !== null || k === 0) lines.push(`${field.n} ${num(value, field.d)} ${value === null ? "" : field.u}`.trim());
    });
    if (heat.s) lines.push(STATUS[heat.s[b][a]]);
    return lines.join("\n");
  };
  for (const group of document.querySelectorAll("[data-heat]")) {
    const heat = data.heats[group.dataset.heat];
    group.addEventListener("pointermove", event => {
      const cell = event.target.dataset.c;
      if (!cell || !heat) return hide();
      const [a, b] = cell.split(" ").map(Number);
      show(describe(heat, a, b), event);
    });
    group.addEventListener("pointerleave", hide);
  }

  // ── surfaces ──
  const mix = place => {
    const stops = data.viridis, at = Math.min(Math.max(place, 0), 1) * (stops.length - 1), k = Math.min(Math.floor(at), stops.length - 2), f = at - k;
    const rgb = hex => [1, 3, 5].map(n => parseInt(hex.slice(n, n + 2), 16));
    const [p, q] = [rgb(stops[k]), rgb(stops[k + 1])];
    return "rgb(" + p.map((c, n) => Math.round(c + f * (q[n] - c))).join(",") + ")";
  };
  const roundStep = span => {
    const power = 10 ** Math.floor(Math.log10(span / 5));
    return [1, 2, 5, 10].map(m => m * power).find(s => span / s <= 5.05) || 10 * power;
  };
  const ticks = (low, high) => {
    const step = roundStep(high - low), found = [];
    for (let k = Math.ceil(low / step - 1e-6); k * step <= high + 1e-6 * step; k++) found.push(k * step);
    return { found, digits: Math.max(0, -Math.floor(Math.log10(step))) };
  };
  const surface = svg => {
    const heat = data.heats[svg.dataset.of];
    if (!heat) return;
    const z = heat.v[0].z, ends = b => [b[0], b[b.length - 1]], X = ends(heat.x.b), Y = ends(heat.y.b), [low, high] = heat.r;
    const unit = (v, [a, b]) => 2 * (v - a) / (b - a) - 1, up = v => 1.3 * ((v - low) / (high - low) - 0.5);
    let turn = -0.62, tilt = 0.5;
    // orthographic: turned about the vertical, then tilted towards the eye
    const eye = (x, y, h) => {
      const c = Math.cos(turn), s = Math.sin(turn), depth = s * x + c * y;
      return [226 + 108 * (c * x - s * y), 184 - 108 * (h * Math.cos(tilt) + depth * Math.sin(tilt)), depth * Math.cos(tilt) - h * Math.sin(tilt)];
    };
    const meshes = [];
    for (let b = 0; b + 1 < heat.y.b.length; b++) for (let a = 0; a + 1 < heat.x.b.length; a++) {
      const corners = [[a, b], [a + 1, b], [a + 1, b + 1], [a, b + 1]];
      const values = corners.map(([i, j]) => z[j][i]);
      if (values.some(v => v === null)) continue;
      const status = heat.s ? corners.map(([i, j]) => heat.s[j][i]) : [];
      const sure = !status.some(s => s === "e" || s === "u");
      const mean = values.reduce((p, q) => p + q) / 4;
      meshes.push({
        at: corners.map(([i, j], k) => [unit(heat.x.b[i], X), unit(heat.y.b[j], Y), up(values[k])]),
        style: `fill:${mix((mean - low) / (high - low))};fill-opacity:${sure ? 1 : 0.45}`,
      });
    }
    const draw = () => {
      svg.textContent = "";
      const back = [Math.sin(turn) > 0 ? 1 : -1, Math.cos(turn) > 0 ? 1 : -1], base = up(low);
      const line = (p, q, c) => make("path", { class: c, d: "M" + [p, q].map(e => eye(...e).slice(0, 2).map(v => v.toFixed(1)).join(" ")).join("L") }, svg);
      const label = (p, text, away) => {
        const [x, y] = eye(...p), [cx] = eye(0, 0, base);
        make("text", { x: x.toFixed(1), y: (y + 4).toFixed(1), class: away || (x < cx ? "e m" : "m") }, svg, text);
      };
      const tx = ticks(...X), ty = ticks(...Y), tz = ticks(low, high);
      for (const t of tx.found) line([unit(t, X), -back[1], base], [unit(t, X), back[1], base], "g");
      for (const t of ty.found) line([-back[0], unit(t, Y), base], [back[0], unit(t, Y), base], "g");
      for (const t of tz.found) {
        line([-1, back[1], up(t)], [1, back[1], up(t)], "g");
        line([back[0], -1, up(t)], [back[0], 1, up(t)], "g");
      }
      const drawn = meshes.map(m => ({ m, p: m.at.map(c => eye(...c)) }));
      drawn.sort((p, q) => q.p.reduce((s, c) => s + c[2], 0) - p.p.reduce((s, c) => s + c[2], 0));
      for (const { m, p } of drawn) {
        make("path", { d: "M" + p.map(c => c[0].toFixed(1) + " " + c[1].toFixed(1)).join("L") + "Z", style: m.style, stroke: "#000", "stroke-opacity": ".18", "stroke-width": ".6" }, svg);
      }
      for (const t of tx.found) label([unit(t, X), -back[1] * 1.1, base], num(t, tx.digits));
      for (const t of ty.found) label([-back[0] * 1.1, unit(t, Y), base], num(t, ty.digits));
      const side = eye(-back[0], back[1], 0)[0] < eye(back[0], -back[1], 0)[0] ? [-back[0], back[1]] : [back[0], -back[1]];
      for (const t of tz.found) label([side[0] * 1.04, side[1] * 1.04, up(t)], num(t, tz.digits), "e");
      const title = (p, text) => {
        const [x, y] = eye(...p), room = 3.4 * text.length;
        make("text", { x: Math.min(Math.max(x, room), 440 - room).toFixed(1), y: Math.min(Math.max(y + 4, 12), 374).toFixed(1), class: "c m" }, svg, text);
      };
      title([side[0] * 1.04, side[1] * 1.04, up(high) + 0.3], `${heat.v[0].n} [${heat.v[0].u}]`);
      // below the labels of their axis, the second a line lower if it would overlap the first
      const names = [[[-1, -back[1] * 1.1, base], [1, -back[1] * 1.1, base], `${heat.x.n} [${heat.x.u}]`],
        [[-back[0] * 1.1, -1, base], [-back[0] * 1.1, 1, base], `${heat.y.n} [${heat.y.u}]`]];
      let taken = null;
      for (const [from, to, text] of names) {
        const p = eye(...from), q = eye(...to), room = 3.4 * text.length;
        const x = Math.min(Math.max((p[0] + q[0]) / 2, room), 440 - room);
        let y = Math.min(Math.max(p[1], q[1]) + 24, 374);
        if (taken && Math.abs(x - taken[0]) < room + taken[2] && Math.abs(y - taken[1]) < 14) y = taken[1] <= 360 ? taken[1] + 14 : taken[1] - 14;
        make("text", { x: x.toFixed(1), y: y.toFixed(1), class: "c m" }, svg, text);
        taken = [x, y, room];
      }
    };
    let from = null;
    svg.addEventListener("pointerdown", event => { from = [event.clientX, event.clientY]; svg.setPointerCapture(event.pointerId); });
    svg.addEventListener("pointermove", event => {
      if (!from) return;
      turn += (event.clientX - from[0]) * 0.01;
      tilt = Math.min(1.4, Math.max(0.05, tilt + (event.clientY - from[1]) * 0.008));
      from = [event.clientX, event.clientY];
      draw();
    });
    for (const end of ["pointerup", "pointercancel"]) svg.addEventListener(end, () => { from = null; });
    svg.addEventListener("keydown", event => {
      const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.08], ArrowDown: [0, 0.08] }[event.key];
      if (!step) return;
      event.preventDefault();
      turn += step[0];
      tilt = Math.min(1.4, Math.max(0.05, tilt + step[1]));
      draw();
    });
    draw();
  };
  document.querySelectorAll("svg.surface").forEach(surface);

  // ── traces of a run ──
  const LEFT = 56, WIDTH = 1010, RIGHT = 14, TOP = 42, GAP = 28, HEIGHTS = [150, 90, 60];
  const traces = run => {
    const height = TOP + HEIGHTS.reduce((a, b) => a + b) + GAP * (HEIGHTS.length - 1) + 38;
    const svg = document.createElementNS(NS, "svg");
    svg.setAttribute("class", "f");
    svg.setAttribute("viewBox", `0 0 ${WIDTH} ${height}`);
    svg.setAttribute("role", "img");
    svg.setAttribute("aria-label", "Traces of the run");
    const t0 = run.t[0], t1 = run.t[run.t.length - 1], sx = t => LEFT + (t - t0) / (t1 - t0 || 1) * (WIDTH - LEFT - RIGHT);
    const clip = t => Math.min(Math.max(t, t0), t1);
    const all = height - 38;
    run.w.forEach(([from, to, number]) => {
      const x = sx(clip(from)), width = sx(clip(to)) - x, used = number === 0, name = data.traces.verdicts[number];
      if (width <= 0) return;
      const band = make("rect", { x: x.toFixed(1), y: TOP - 18, width: width.toFixed(1), height: all - TOP + 18, style: used ? "fill:var(--a);fill-opacity:.07" : "fill:var(--muted);fill-opacity:.17", "data-verdict": name }, svg);
      make("title", {}, band, name);
      make("rect", { x: x.toFixed(1), y: TOP - 18, width: width.toFixed(1), height: 4, style: used ? "fill:var(--a)" : "fill:var(--muted)" }, svg);
      if (width > 6.3 * name.length) make("text", { x: (x + 4).toFixed(1), y: TOP - 4, class: "m" }, svg, name);
    });
    for (const t of run.h || []) make("path", { class: "x d", d: `M${sx(clip(t)).toFixed(1)} ${TOP - 18}V${all}` }, svg);
    const steps = run.c.flatMap(([t, v], k) => [[clip(t), v], [k + 1 < run.c.length ? clip(run.c[k + 1][0]) : t1, v]]);
    const zip = values => run.t.map((t, k) => [t, values[k]]);
    const panels = [
      ["speed [m/s]", [["recorded", "kf", zip(run.v), "dots"], ["simulated", "a", zip(run.s)]]],
      ["torque [N·m]", [["commanded", "k d", steps], ["after dead time and lag", "a", zip(run.u)]]],
      ["wheel angle [°]", [["", "k", zip(run.a)]]],
    ];
    let top = TOP;
    panels.forEach(([title, lines], n) => {
      const bottom = top + HEIGHTS[n], values = lines.flatMap(l => l[2].map(p => p[1])).filter(v => v !== null);
      let low = Math.min(...values), high = Math.max(...values);
      if (n === 0 && low > -0.04 * high) low = 0;
      if (n < 2) { low = Math.min(low, 0); high = Math.max(high, 0); }
      if (high - low < 1e-6 || (n === 2 && high - low < 2)) { const middle = (low + high) / 2; low = middle - 1; high = middle + 1; }
      const step = roundStep(high - low);
      low = Math.floor(low / step + 1e-9) * step;
      high = Math.ceil(high / step - 1e-9) * step;
      const sy = v => bottom - (v - low) / (high - low) * (bottom - top);
      const { found, digits } = ticks(low, high);
      for (const t of n ? found.filter((_, k) => k % 2 === 0) : found) {
        make("path", { class: "g", d: `M${LEFT} ${sy(t).toFixed(1)}H${WIDTH - RIGHT}` }, svg);
        make("text", { x: LEFT - 7, y: (sy(t) + 4).toFixed(1), class: "e" }, svg, num(t, digits));
      }
      make("text", { x: LEFT, y: top - (n ? 8 : 25), class: "t" }, svg, title);
      let x = WIDTH - RIGHT;
      for (const [name, kind, points, dots] of lines.slice().reverse()) {
        let d = "", pen = false;
        for (const [t, v] of points) {
          if (v === null) { pen = false; continue; }
          if (dots) make("circle", { class: kind, cx: sx(t).toFixed(1), cy: sy(v).toFixed(1), r: 1.9 }, svg);
          d += (pen ? "L" : "M") + sx(t).toFixed(1) + " " + sy(v).toFixed(1);
          pen = true;
        }
        if (!dots) make("path", { class: "l " + kind, d }, svg);
        if (!name) continue;
        const y = top - (n ? 8 : 25);
        make("text", { x, y, class: "e m" }, svg, name);
        x -= 7 * name.length + 14;
        if (dots) make("circle", { class: kind, cx: x - 6, cy: y - 4, r: 2.2 }, svg);
        else make("path", { class: "l " + kind, d: `M${x - 18} ${y - 4}H${x}` }, svg);
        x -= 30;
      }
      top = bottom + GAP;
    });
    const axis = ticks(t0, t1);
    for (const t of axis.found) make("text", { x: sx(t).toFixed(1), y: all + 16, class: "c" }, svg, num(t, axis.digits));
    make("text", { x: (LEFT + WIDTH - RIGHT) / 2, y: all + 32, class: "c m" }, svg, "time in the log [s]");
    return svg;
  };
  const toggle = row => {
    const open = row.getAttribute("aria-expanded") === "true";
    row.setAttribute("aria-expanded", String(!open));
    if (open) return row.nextElementSibling.remove();
    const line = document.createElement("tr"), cell = document.createElement("td");
    line.className = "traces";
    cell.colSpan = row.cells.length;
    cell.appendChild(traces(data.traces.runs[row.dataset.row]));
    line.appendChild(cell);
    row.after(line);
    line.scrollIntoView({ block: "nearest" });
  };
  for (const row of document.querySelectorAll("tr.click")) {
    row.addEventListener("click", () => toggle(row));
    row.addEventListener("keydown", event => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      toggle(row);
    });
  }

  // ── sorting the runs ──
  for (const table of document.querySelectorAll("table.runs")) {
    const heads = [...table.tHead.rows[0].cells], body = table.tBodies[0];
    heads.forEach((head, column) => {
      head.tabIndex = 0;
      const sort = () => {
        const falling = head.getAttribute("aria-sort") === "ascending";
        heads.forEach(h => h.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", falling ? "descending" : "ascending");
        body.querySelectorAll("tr.traces").forEach(line => line.remove());
        const rows = [...body.rows];
        rows.forEach(row => row.hasAttribute("aria-expanded") && row.setAttribute("aria-expanded", "false"));
        const key = row => {
          const text = row.cells[column].textContent, value = parseFloat(text.replace("−", "-"));
          return head.classList.contains("l") ? text : value;
        };
        const missing = v => typeof v === "number" && isNaN(v);
        rows.sort((p, q) => {
          const [a, b] = [key(p), key(q)];
          // missing values come last in both orders
          if (missing(a) || missing(b)) return missing(a) - missing(b);
          const order = typeof a === "string" ? a.localeCompare(b) : a - b;
          return falling ? -order : order;
        });
        rows.forEach(row => body.appendChild(row));
      };
      head.addEventListener("click", sort);
      head.addEventListener("keydown", event => { if (event.key === "Enter") sort(); });
    });
  }
})();
