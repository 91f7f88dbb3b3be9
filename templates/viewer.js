"use strict";
// Steps through the frames of a path: deformed shape, joint forces and the marker on the curve move together.
// Points are (x, z) in m; the drawing shows z upwards, so that SVG's y is −z.
(() => {
  const data = JSON.parse(document.getElementById("viewer-data").textContent);
  const { words } = data;
  const $ = (id) => document.getElementById(id);
  const [shape, curve, slider, choice, tip] = ["shape", "curve", "frame", "path", "tip"].map((id) => $(`viewer-${id}`));
  const floats = (text) => new Float32Array(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
  const number = (value, digits = 3) =>
    Number.isFinite(value) ? String(+value.toPrecision(digits)).replace("-", "−").replace(".", words.decimal_mark) : "–";
  const millimetres = (metres) => number(Math.abs(metres) < 5e-7 ? 0 : 1e3 * metres);
  const safe = (text) => String(text).replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);
  const bounds = (points) => {
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    for (const [x, z] of points) {
      box[0] = Math.min(box[0], x); box[1] = Math.min(box[1], z);
      box[2] = Math.max(box[2], x); box[3] = Math.max(box[3], z);
    }
    return box;
  };
  const drawn = bounds(data.blocks.flatMap((block) => block.vertices));
  const size = Math.max(drawn[2] - drawn[0], drawn[3] - drawn[1]);
  let path, frame, configuration, pairs, joints, times, over = null, playing = null;

  // ---- geometry ----
  const motion = (block, of = configuration, at = frame) =>
    of.subarray(3 * (at * data.blocks.length + block)).subarray(0, 3);
  const placed = (point, block, magnified = times) => displaced(point, block, motion(block), magnified);
  const displaced = ([x, z], block, [dx, dz, turn], magnified) => {
    const [cx, cz] = data.blocks[block].centroid;
    const [c, s] = [Math.cos(turn), Math.sin(turn)], [ax, az] = [x - cx, z - cz];
    return [x + magnified * (dx + c * ax - s * az - ax), z + magnified * (dz + s * ax + c * az - az)];
  };
  const magnified = (point, index) => {
    // A point of joint `index` where its blocks are drawn: halfway between where either of the two would carry it.
    const moved = pairs[index].map((block) => {
      const [dx, dz, turn] = motion(block), [cx, cz] = data.blocks[block].centroid;
      const [c, s] = [Math.cos(turn), Math.sin(turn)], [ax, az] = [point[0] - cx - dx, point[1] - cz - dz];
      return [dx + ax - c * ax - s * az, dz + az + s * ax - c * az];
    });
    return point.map((x, k) => x + ((times - 1) * (moved[0][k] + moved[1][k])) / 2);
  };
  const line = (points) => points.map(([x, z]) => `${x.toFixed(5)},${(-z).toFixed(5)}`).join(" ");

  const jointAt = (index) => {
    // What joint `index` does in this frame, as the results have it; no forces where they are not known.
    const at = 15 * (frame * pairs.length + index), of = (k) => joints[at + k];
    const ends = [[of(0), of(1)], [of(2), of(3)]], opening = [of(11), of(12)], slip = of(13);
    const shown = ends.map((end) => magnified(end, index));
    if (Number.isNaN(of(14))) return { ends: shown, opening, slip };
    const [N, T] = [of(6), of(7)], [dx, dz] = [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]];
    const length = Math.hypot(dx, dz) || 1, t = [dx / length, dz / length], n = [-t[1], t[0]];
    return { ends: shown, opening, slip, N, T, point: magnified([of(4), of(5)], index), F: [0, 1].map((i) => N * n[i] + T * t[i]),
      eccentricity: of(8), contact: of(9), pressure: of(10), condition: data.conditions[Math.round(of(14))] };
  };

  // ---- drawing ----
  const drawShape = () => {
    const states = pairs.map((_, index) => jointAt(index));
    const outline = (block, moved) => line(block.vertices.map(moved));
    const parts = [];
    data.blocks.forEach((block) => parts.push(`<polygon class="ghost" points="${outline(block, (v) => v)}"/>`));
    data.blocks.forEach((block, index) => {
      const points = outline(block, (v) => placed(v, index));
      parts.push(`<polygon class="${block.support ? "support" : "block"}" data-block="${index}" points="${points}"/>`);
    });
    states.forEach((joint) => {
      if (["partial", "sliding", "idle"].includes(joint.condition))
        parts.push(`<polyline class="joint ${joint.condition}" points="${line(joint.ends)}"/>`);
    });
    if (over) data.blocks.forEach((block, index) => {
      const moved = motion(index, over.configuration, nearest(over.path, path.frames.x[frame]));
      parts.push(`<polygon class="over" points="${outline(block, (v) => displaced(v, index, moved, times))}"/>`);
    });
    ties().forEach(({ index, ends, slack }) => parts.push(
      `<polyline class="tie${slack ? " slack" : ""}" points="${line(ends)}"/>`,
      ...ends.map(([x, z]) => `<circle class="anchor" cx="${x}" cy="${-z}" r="${0.006 * size}"/>`),
      `<polyline class="touch" data-tie="${index}" points="${line(ends)}"/>`));
    if ($("viewer-forces").checked) parts.push(...forces(states));
    states.forEach((joint, index) =>
      parts.push(`<polyline class="touch" data-joint="${index}" points="${line(joint.ends)}"/>`));
    shape.innerHTML = parts.join("");
  };

  const ties = () => path.frames.ties.map((number, index) => {
    const tie = data.ties[number], known = path.frames.tension[frame];
    const N = known?.[index] ?? NaN;
    return { index, tie, N, slack: N <= data.slack,
      ends: tie.ends.map((end, k) => placed(end, tie.blocks[k])) };
  });

  const forces = (states) => {
    const loaded = data.blocks.map(() => []), parts = [];
    const largest = Math.max(...states.map((joint) => (joint.F ? Math.hypot(...joint.F) : 0)), 1e-12);
    states.forEach((joint, index) => {
      if (!joint.F || joint.condition === "idle") return;
      pairs[index].forEach((block) => loaded[block].push(joint.point));
      const half = joint.F.map((f) => (0.04 * size * f) / largest), [x, z] = joint.point;
      parts.push(`<polyline class="resultant" points="${line([[x - half[0], z - half[1]], [x + half[0], z + half[1]]])}"/>`);
    });
    loaded.filter((points) => points.length === 2)
      .forEach((points) => parts.push(`<polyline class="thrust" points="${line(points)}"/>`));
    states.filter((joint) => joint.condition === "edge").forEach(({ point: [x, z] }) =>
      parts.push(`<circle class="hinge" cx="${x}" cy="${-z}" r="${0.007 * size}"/>`));
    return parts;
  };

  const W = 640, H = 260, M = { left: 62, right: 12, top: 12, bottom: 40 };
  let scaleX, scaleY;
  const ticks = (low, high) => {
    const raw = (high - low) / 5, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((k) => k * power).find((each) => each >= raw);
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
    return found;
  };
  const scale = (values, from, to) => {
    let low = Math.min(0, ...values), high = Math.max(0, ...values);
    if (high - low < 1e-12) high = low + 1;
    return Object.assign((v) => from + ((v - low) / (high - low)) * (to - from), { low, high });
  };
  const nearest = (other, x) => {
    const off = other.frames.x.map((value) => Math.abs(value - x));
    return off.indexOf(Math.min(...off));
  };
  const shownTogether = () => [...path.series, ...(over ? over.path.series : [])];
  const finite = (key) => shownTogether().flatMap((each) => each[key]).filter(Number.isFinite);
  const drawCurve = () => {
    scaleX = scale(finite("x"), M.left, W - M.right);
    scaleY = scale(finite("y"), H - M.bottom, M.top);
    const parts = [];
    for (const v of ticks(scaleX.low, scaleX.high)) parts.push(
      `<line class="grid" x1="${scaleX(v)}" x2="${scaleX(v)}" y1="${M.top}" y2="${H - M.bottom}"/>`,
      `<text x="${scaleX(v)}" y="${H - M.bottom + 14}" text-anchor="middle">${number(v, 6)}</text>`);
    for (const v of ticks(scaleY.low, scaleY.high)) parts.push(
      `<line class="grid" x1="${M.left}" x2="${W - M.right}" y1="${scaleY(v)}" y2="${scaleY(v)}"/>`,
      `<text x="${M.left - 5}" y="${scaleY(v) + 3}" text-anchor="end">${number(v, 6)}</text>`);
    path.series.forEach((each, k) => {
      const points = each.x.map((x, i) => `${scaleX(x).toFixed(2)},${scaleY(each.y[i]).toFixed(2)}`).join(" ");
      parts.push(`<polyline class="series s${k}" points="${points}"/>`);
    });
    if (over) over.path.series.forEach((each) => {
      const points = each.x.map((x, i) => `${scaleX(x).toFixed(2)},${scaleY(each.y[i]).toFixed(2)}`).join(" ");
      parts.push(`<polyline class="series over" points="${points}"/>`);
    });
    parts.push(`<text x="${(M.left + W - M.right) / 2}" y="${H - 8}" text-anchor="middle">${safe(path.x_label)}</text>`,
      `<text transform="translate(12 ${(M.top + H - M.bottom) / 2}) rotate(-90)" text-anchor="middle">${safe(path.y_label)}</text>`,
      `<line id="viewer-cursor" class="cursor" y1="${M.top}" y2="${H - M.bottom}"/>`,
      ...path.series.map((_, k) => `<circle class="marker" id="viewer-marker-${k}" r="5"/>`));
    curve.innerHTML = parts.join("");
  };

  const drawMarkers = () => {
    const x = path.frames.x[frame], unit = /\[(.+)\]/.exec(path.y_label)?.[1] ?? "";
    $("viewer-cursor").setAttribute("x1", scaleX(x)); $("viewer-cursor").setAttribute("x2", scaleX(x));
    const shown = path.series.map((each, k) => {
      const y = path.frames.y[k][frame], marker = $(`viewer-marker-${k}`);
      marker.setAttribute("cx", scaleX(x)); marker.setAttribute("cy", scaleY(y));
      return `${each.label} = ${number(y)} ${unit}`.trim();
    });
    const said = [`${frame + 1}/${path.frames.x.length}`, `${path.x_label}: ${number(x)}`, ...shown];
    $("viewer-values").textContent = said.join("   ");
    slider.setAttribute("aria-valuetext", said.join("; "));
  };

  // ---- state ----
  const show = (index) => {
    frame = Math.max(0, Math.min(path.frames.x.length - 1, index));
    slider.value = frame;
    drawShape();
    drawMarkers();
  };
  const fit = () => {
    // the frame holds every configuration of the path, as far as half the model's size around the drawing
    const kept = frame, corners = [];
    for (frame = 0; frame < path.frames.x.length; frame++)
      data.blocks.forEach((block, index) => corners.push(...block.vertices.map((v) => placed(v, index))));
    frame = kept;
    const box = bounds(corners), pad = 0.04 * size, room = 0.5 * size;
    const [x0, z0] = [0, 1].map((i) => Math.max(Math.min(box[i], drawn[i]), drawn[i] - room) - pad);
    const [x1, z1] = [2, 3].map((i) => Math.min(Math.max(box[i], drawn[i]), drawn[i] + room) + pad);
    shape.setAttribute("viewBox", `${x0} ${-z1} ${x1 - x0} ${z1 - z0}`);
  };
  const select = (index) => {
    path = data.paths[index];
    configuration = floats(path.frames.configuration);
    pairs = path.frames.pairs;
    joints = floats(path.frames.joints);
    slider.max = path.frames.x.length - 1;
    frame = 0;
    offer(index);
    magnify();
    drawCurve();
    show(0);
  };
  const offer = (index) => {
    // the jumps of this path, and the paths of the same axes that can lie over it
    $("viewer-jumps").replaceChildren(...path.jumps.map(({ label, x }) => {
      const button = document.createElement("button");
      button.type = "button";
      const [symbol, limit] = label.split("_"), below = document.createElement("sub");
      below.textContent = limit;
      button.append(symbol, below, ` = ${number(x)} mm`);
      button.addEventListener("click", () => { stop(); show(nearest(path, x)); });
      return button;
    }));
    const select = $("viewer-over");
    while (select.options.length > 1) select.remove(1);
    data.paths.forEach((each, other) => {
      if (other !== index && each.x_label === path.x_label && each.y_label === path.y_label)
        select.add(new Option(each.title, other));
    });
    select.value = "";
    over = null;
  };
  const lay = () => {
    const chosen = $("viewer-over").value, other = chosen === "" ? null : data.paths[+chosen];
    over = other && { path: other, configuration: floats(other.frames.configuration) };
    drawCurve();
    show(frame);
  };
  const magnify = () => { times = +$("viewer-times").value; fit(); };
  const stop = () => { clearInterval(playing); playing = null; $("viewer-play").textContent = "▶"; };
  const play = () => {
    if (playing) return stop();
    if (frame === path.frames.x.length - 1) show(0);
    $("viewer-play").textContent = "❚❚";
    playing = setInterval(() => (frame === path.frames.x.length - 1 ? stop() : show(frame + 1)), 80);
  };

  // ---- tooltips ----
  const rows = (title, pairs) => `<b>${safe(title)}</b>` + pairs.map(([k, v]) => `<br>${safe(k)}: ${safe(v)}`).join("");
  const blockTip = (index) => {
    const block = data.blocks[index], [dx, dz, turn] = motion(index);
    return rows(`${words.block} ${index}`, [
      [words.layer, block.layer + (block.support ? ` (${words.support} “${block.support}”)` : "")],
      [words.weight, `${number(block.weight)} kN`],
      [words.displacement, `${millimetres(dx)}; ${millimetres(dz)} mm`],
      [words.rotation, `${number(1e3 * turn)} mrad`]]);
  };
  const jointTip = (index) => {
    const joint = jointAt(index), [a, b] = pairs[index];
    const told = [[words.opening, joint.opening.map(millimetres).join("; ") + " mm"],
      [words.slip, `${millimetres(joint.slip)} mm`]];
    if (joint.F) told.unshift([words.condition, words[joint.condition]],
      [words.forces, `N = ${number(joint.N)}, T = ${number(joint.T)} kN`],
      [words.eccentricity, `${millimetres(joint.eccentricity)} mm`],
      [words.contact, `${millimetres(joint.contact)} mm`],
      [words.pressure, `${joint.pressure === Infinity ? "∞" : number(0.001 * joint.pressure)} MPa`]);
    return rows(`${words.joint} ${index} (${a}–${b})`, told);
  };
  const tieTip = (index) => {
    const { tie, N, slack } = ties()[index];
    const pairs = [[words.tension, slack ? words.slack : `${number(N)} kN`]];
    if (tie.yield !== null) pairs.push([words.yield_force, `${number(tie.yield)} kN`]);
    return rows(`${words.tie} “${tie.name}”`, pairs);
  };
  const hover = (event) => {
    const { block, joint, tie } = event.target.dataset;
    tip.hidden = block === undefined && joint === undefined && tie === undefined;
    if (tip.hidden) return;
    tip.innerHTML = tie !== undefined ? tieTip(+tie) : joint === undefined ? blockTip(+block) : jointTip(+joint);
    tip.style.left = `${event.pageX + 14}px`;
    tip.style.top = `${event.pageY + 14}px`;
  };
  const pick = (event) => {
    const box = curve.getBoundingClientRect(), x = ((event.clientX - box.left) / box.width) * W;
    const off = path.frames.x.map((value) => Math.abs(scaleX(value) - x));
    stop();
    show(off.indexOf(Math.min(...off)));
  };

  data.paths.forEach((each, index) => choice.add(new Option(each.title, index)));
  choice.addEventListener("change", () => { stop(); select(+choice.value); });
  slider.addEventListener("input", () => { stop(); show(+slider.value); });
  $("viewer-times").addEventListener("change", () => { magnify(); show(frame); });
  $("viewer-over").addEventListener("change", lay);
  $("viewer-forces").addEventListener("change", () => show(frame));
  $("viewer-play").addEventListener("click", play);
  shape.addEventListener("pointermove", hover);
  shape.addEventListener("pointerleave", () => { tip.hidden = true; });
  curve.addEventListener("pointerdown", pick);
  curve.addEventListener("pointermove", (event) => { if (event.buttons) pick(event); });
  curve.setAttribute("viewBox", `0 0 ${W} ${H}`);
  select(0);
})();
