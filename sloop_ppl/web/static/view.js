// A city map with beliefs, frames and a search drawn over it: one module without imports, for the
// workbench, for a page of its own without a server, and for notebooks (anywidget).

const SVG = "http://www.w3.org/2000/svg";

export function svg(name, attributes = {}, ...children) {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

export function html(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (value === true) node.setAttribute(key, "");
    else if (value !== false && value != null) node.setAttribute(key, value);
  }
  node.append(...children.filter((child) => child != null));
  return node;
}

// Tables

const bytes = (base64) => Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));

/** Numbers of a table that came as float16 shares of its peak, row 0 in the south. */
export function numbers(packed) {
  const data = new DataView(bytes(packed.f16).buffer);
  const found = new Float32Array(data.byteLength / 2);
  for (let i = 0; i < found.length; i++) {
    const half = data.getUint16(2 * i, true), exponent = (half >> 10) & 31, part = half & 1023;
    const share = exponent ? 2 ** (exponent - 15) * (1 + part / 1024) : part * 2 ** -24;
    found[i] = share * packed.peak;
  }
  return found;
}

export function bits(base64, size) {
  const data = bytes(base64);
  return Array.from({ length: size }, (_, i) => (data[i >> 3] >> (7 - (i & 7))) & 1);
}

export const percent = (p) => {
  const value = 100 * p;
  if (p > 0 && value < 0.01) return "< 0.01 %";
  return `${value >= 10 ? value.toFixed(0) : value >= 1 ? value.toFixed(1) : value.toFixed(2)} %`;
};

let serial = 0;

/** The corners of an area: of its four borders, or as it has them. */
const cornersOf = (area) => {
  if (Array.isArray(area[0])) return area;
  const [w, s, e, n] = area;
  return [[w, s], [e, s], [e, n], [w, n]];
};

const NEAR_PX = 9; // so near to a corner a click is on it

/** The map. `on` holds callbacks: cell(cell), pick([x, y], event), area(borders or corners), drag(from, to),
    corner(number of corners so far). */
export class CityView {
  constructor(element, scene, colours, on = {}) {
    Object.assign(this, { element, scene, colours, on, tool: "look", cursor: null, values: null, corners: [] });
    const [west, south, east, north] = scene.cells_extent_m;
    [this.rows, this.columns] = scene.shape;
    this.whole = [west, -north, east - west, north - south];
    this.box = [...this.whole];
    this.layers = {};
    this.root = svg("svg", {
      class: "map", tabindex: "0", role: "application",
      "aria-roledescription": "map", preserveAspectRatio: "xMidYMid meet",
    });
    this.root.style.setProperty("--ratio", this.whole[2] / this.whole[3]);
    const clip = `clip-${++serial}`;
    this.root.append(svg("clipPath", { id: clip }, svg("rect", this.rect(this.whole))));
    const all = svg("g", { "clip-path": `url(#${clip})` });
    all.append(svg("rect", { ...this.rect(this.whole), class: "ground" }));
    for (const name of ["land", "mentioned", "belief", "area", "draft", "contours", "view", "names", "frames",
      "evidence", "path", "marks", "cursor"]) {
      all.append((this.layers[name] = svg("g", { class: name })));
    }
    this.root.append(all);
    element.append(this.root);
    this.drawLand();
    this.listen();
    this.zoomTo(this.whole);
    new ResizeObserver(() => this.rescale()).observe(this.root);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.repaint());
  }

  rect([x, y, width, height]) { return { x, y, width, height }; }

  drawLand() {
    for (const one of this.scene.landmarks) {
      if (one.path) {
        const shape = svg("path", { d: one.path, class: `land-${one.kind}`, "data-id": one.id });
        if (one.width_m) {
          shape.classList.add("line");
          shape.style.strokeWidth = one.width_m;
        }
        this.layers.land.append(shape);
      } else {
        const [x, y] = one.point;
        this.layers.land.append(svg("circle", { cx: x, cy: -y, class: "land-poi", "data-id": one.id }));
      }
    }
  }

  // Size on the screen

  zoomTo(box) {
    const [x0, y0, w0, h0] = this.whole;
    const w = Math.min(box[2], w0), h = Math.min(box[3], h0);
    this.box = [Math.min(Math.max(box[0], x0), x0 + w0 - w), Math.min(Math.max(box[1], y0), y0 + h0 - h), w, h];
    this.root.setAttribute("viewBox", this.box.join(" "));
    this.rescale();
  }

  zoom(factor, centre = [this.box[0] + this.box[2] / 2, this.box[1] + this.box[3] / 2]) {
    const width = Math.max(this.box[2] * factor, 4 * this.scene.cell_m), f = width / this.box[2];
    const [x, y] = centre;
    this.zoomTo([x - (x - this.box[0]) * f, y - (y - this.box[1]) * f, width, this.box[3] * f]);
  }

  pan(dx, dy) { this.zoomTo([this.box[0] + dx, this.box[1] + dy, this.box[2], this.box[3]]); }

  rescale() {
    const { width, height } = this.root.getBoundingClientRect();
    if (!width || !height) return;
    const root = parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;
    const metres = root * Math.max(this.box[2] / width, this.box[3] / height); // of a pixel at 16 px a letter
    this.root.style.setProperty("--px", metres);
    if (metres === this.metresPerPixel && this.namesAt === this.box.join()) return;
    this.metresPerPixel = metres;
    this.namesAt = this.box.join();
    this.drawNames();
  }

  /** Names of places, the important first, none over another. */
  drawNames() {
    const m = this.metresPerPixel, size = 11 * m, taken = [], found = [];
    const important = new Set(this.mentioned ?? []);
    const named = this.scene.landmarks.filter((one) => one.name);
    named.sort((a, b) => important.has(b.id) - important.has(a.id) || b.size_m - a.size_m);
    const [bx, by, bw, bh] = this.box;
    for (const one of named) {
      const [x, north] = one.label_at, y = -north - (one.path ? 0 : 8 * m);
      const width = 0.56 * size * one.name.length;
      if (!important.has(one.id) && one.path && one.kind === "building" && one.size_m < 14 * m) continue;
      const left = Math.min(Math.max(x - width / 2, bx + 3 * m), bx + bw - width - 3 * m);
      const box = [left, y - 0.6 * size, left + width, y + 0.6 * size];
      if (x < bx || x > bx + bw || y < by || y > by + bh || width > bw) continue;
      if (taken.some((t) => box[0] < t[2] && t[0] < box[2] && box[1] < t[3] && t[1] < box[3])) continue;
      taken.push(box);
      const text = svg("text", { x: left + width / 2, y, class: `name name-${one.kind}` });
      if (important.has(one.id)) text.classList.add("important");
      text.textContent = one.name;
      found.push(text);
    }
    this.layers.names.replaceChildren(...found);
  }

  mention(ids) {
    this.mentioned = ids;
    const shapes = ids.flatMap((id) => {
      const one = this.scene.landmarks.find((l) => l.id === id);
      const d = one?.path || one?.path_within;
      const outline = d ? [svg("path", { d, class: one.width_m ? "line" : "" })] : [];
      return one && !one.path
        ? [...outline, svg("circle", { cx: one.point[0], cy: -one.point[1] })] : outline;
    });
    this.layers.mentioned.replaceChildren(...shapes);
    if (this.metresPerPixel) this.drawNames();
  }

  // Cells

  isDark() {
    const chosen = document.documentElement.dataset.theme;
    return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  }

  /** Draw a table over the cells; of a difference, 0 is in the middle of the colours. */
  setValues(values, { difference = false } = {}) {
    this.values = values;
    this.isDifference = difference;
    this.repaint();
  }

  repaint() {
    if (!this.values) { this.layers.belief.replaceChildren(); return; }
    const name = this.isDifference ? "difference" : this.isDark() ? "belief_dark" : "belief";
    const table = bytes(this.colours[name]), last = table.length / 4 - 1;
    let most = 0;
    for (const value of this.values) most = Math.max(most, Math.abs(value));
    const image = new ImageData(this.columns, this.rows);
    this.values.forEach((value, i) => {
      const share = most ? value / most : 0;
      const colour = Math.round((this.isDifference ? (share + 1) / 2 : share) * last);
      const row = this.rows - 1 - Math.floor(i / this.columns);
      image.data.set(table.subarray(4 * colour, 4 * colour + 4), 4 * (row * this.columns + (i % this.columns)));
    });
    const canvas = html("canvas", { width: this.columns, height: this.rows });
    canvas.getContext("2d").putImageData(image, 0, 0);
    const drawn = svg("image", { ...this.rect(this.whole), preserveAspectRatio: "none", href: canvas.toDataURL() });
    this.layers.belief.replaceChildren(drawn);
  }

  /** The border of a set of cells, as path data. */
  outline(mask) {
    const { cell_m: side, cells_extent_m: [west, south] } = this.scene;
    const at = (row, column) => row >= 0 && row < this.rows && column >= 0 && column < this.columns && mask[row * this.columns + column] === 1;
    const parts = [];
    for (let row = 0; row <= this.rows; row++) {
      for (let column = 0; column <= this.columns; column++) {
        const x = west + column * side, y = -(south + row * side);
        if (at(row, column) !== at(row - 1, column)) parts.push(`M${x} ${y}h${side}`);
        if (at(row, column) !== at(row, column - 1)) parts.push(`M${x} ${y}v${-side}`);
      }
    }
    return parts.join("");
  }

  squares(mask) {
    const { cell_m: s, cells_extent_m: [west, south] } = this.scene;
    let path = "";
    mask.forEach((on, i) => {
      if (!on) return;
      const x = west + (i % this.columns) * s, y = -(south + Math.floor(i / this.columns) * s);
      path += `M${x} ${y}h${s}v${-s}h${-s}z`;
    });
    return path;
  }

  setContours(contours) {
    this.layers.contours.replaceChildren(...contours.map(({ mask, name }) => {
      const d = this.outline(bits(mask, this.rows * this.columns));
      return svg("g", { class: name }, svg("path", { d, class: "halo" }), svg("path", { d }));
    }));
  }

  cellOf(x, y) {
    const { cell_m: side, cells_extent_m: [west, south] } = this.scene;
    const column = Math.floor((x - west) / side), row = Math.floor((y - south) / side);
    return row >= 0 && row < this.rows && column >= 0 && column < this.columns ? row * this.columns + column : null;
  }

  centreOf(cell) {
    const { cell_m: side, cells_extent_m: [west, south], extent_m: [, low, east] } = this.scene;
    const x = west + ((cell % this.columns) + 0.5) * side;
    const y = south + (Math.floor(cell / this.columns) + 0.5) * side;
    return [Math.min(x, east), Math.max(y, low)]; // cells of the overhang: the nearest place inside
  }

  // Marks

  /** Which way grounds face: an arrow each, as long as it is probable and sure. */
  setFrames(frames) {
    this.layers.frames.replaceChildren(...frames.flatMap((one) => {
      if (!one.at?.length || one.p < 0.02) return [];
      const [x, y] = one.at, px = this.metresPerPixel ?? 0.3;
      const length = (28 + 44 * Math.sqrt(one.p)) * px;
      const spread = one.kappa ? Math.min(1 / Math.sqrt(one.kappa), 1.4) : 0;
      const node = svg("g", { class: "frame", transform: `translate(${x} ${-y}) rotate(${(-one.angle_rad * 180) / Math.PI})`,
        "data-ground": one.ground, "data-angle": one.angle_rad });
      node.style.opacity = 0.35 + 0.65 * one.p;
      const tip = [length * Math.cos(spread), length * Math.sin(spread)];
      if (spread) node.append(svg("path", { class: "spread", d: `M0 0L${tip[0]} ${-tip[1]}A${length} ${length} 0 0 1 ${tip[0]} ${tip[1]}Z` }));
      const d = `M0 0H${length}m${-8 * px} ${-5 * px}l${8 * px} ${5 * px}l${-8 * px} ${5 * px}`;
      node.append(svg("path", { class: "arrow halo", d }), svg("path", { class: "arrow", d }));
      const title = svg("title");
      title.textContent = `${one.label ?? one.ground} faces this way (${one.relation}): ${percent(one.p)}`;
      node.append(title);
      return [node];
    }));
  }

  setArea(area) {
    if (!area) return this.layers.area.replaceChildren();
    const [x, y, width, height] = this.whole;
    const outside = `M${x} ${y}h${width}v${height}h${-width}z`, border = `${this.line(cornersOf(area))}z`;
    this.layers.area.replaceChildren(
      svg("path", { class: "outside", "fill-rule": "evenodd", d: outside + border }),
      svg("path", { class: "inside", d: border }),
    );
  }

  line(points) { return points.map(([x, y], i) => `${i ? "L" : "M"}${x} ${-y}`).join(""); }

  // A polygon while it is drawn

  /** Set one more corner; at the first or the last one the polygon is closed. */
  addCorner(at, reach = NEAR_PX * (this.metresPerPixel ?? 0.3)) {
    const [x, y] = at.map((v) => Math.round(v * 10) / 10);
    const isAt = (corner) => corner && Math.hypot(corner[0] - x, corner[1] - y) < reach;
    if (isAt(this.corners[0]) || isAt(this.corners.at(-1))) {
      if (this.corners.length < 3) return this.on.corner?.(this.corners.length);
      const area = this.corners;
      this.dropCorners(area.length);
      this.on.area?.(area);
    } else {
      this.corners = [...this.corners, [x, y]];
      this.drawDraft();
      this.on.corner?.(this.corners.length);
    }
  }

  /** Take back the last corners. */
  dropCorners(count) {
    this.corners = this.corners.slice(0, Math.max(this.corners.length - count, 0));
    this.drawDraft();
  }

  /** The corners so far, with a line to the pointer. */
  drawDraft(towards = null) {
    const corners = this.corners, points = towards && corners.length ? [...corners, towards] : corners;
    this.layers.draft.replaceChildren(
      svg("path", { d: points.length > 2 ? `${this.line(points)}z` : "", class: "fill" }),
      svg("path", { d: this.line(points), class: "halo" }), svg("path", { d: this.line(points) }),
      ...corners.map(([x, y], i) => svg("circle", { cx: x, cy: -y, class: i ? "" : "first" })));
  }

  setEvidence(list) {
    this.layers.evidence.replaceChildren(...list.map(({ at: [x, y], radius_m, is_there }) => {
      const node = svg("g", { class: is_there ? "there" : "absent", transform: `translate(${x} ${-y})` });
      const r = Math.max(radius_m, this.scene.cell_m * 0.7), d = r * 0.5;
      node.append(svg("circle", { r }));
      if (!is_there) node.append(svg("path", { d: `M${-d} ${-d}L${d} ${d}M${-d} ${d}L${d} ${-d}` }));
      return node;
    }));
  }

  /** True places (pins, with a letter) and the start. */
  setMarks(places, start) {
    const marks = Object.entries(places).map(([name, [x, y]]) => {
      const node = svg("g", { class: "place", transform: `translate(${x} ${-y})`, "data-target": name });
      node.append(svg("path", { d: "M0 0C-5 -7 -8 -10 -8 -15A8 8 0 0 1 8 -15C8 -10 5 -7 0 0Z" }), svg("circle", { cy: -15, r: 3 }));
      const title = svg("title");
      title.textContent = `${name} truly is here`;
      node.append(title);
      return svg("g", {}, node);
    });
    if (start) marks.push(svg("circle", { class: "start", cx: start[0], cy: -start[1] }));
    this.layers.marks.replaceChildren(...marks);
  }

  /** The drone after a step: poses so far, what it sees, where it means to go. */
  setDrone(poses, view, plan, seen = {}) {
    if (!poses.length) {
      this.layers.path.replaceChildren();
      this.layers.view.replaceChildren();
      return;
    }
    const [x, y, heading] = poses.at(-1);
    const drone = svg("g", { class: "drone", transform: `translate(${x} ${-y}) rotate(${(-heading * 180) / Math.PI})` });
    drone.append(svg("path", { d: "M11 0L-8 -8L-4 0L-8 8Z" }));
    this.layers.path.replaceChildren(
      svg("path", { class: "plan", d: this.line([[x, y], ...plan]) }),
      svg("path", { class: "flown halo", d: this.line(poses) }),
      svg("path", { class: "flown", d: this.line(poses) }),
      ...Object.values(seen).map(([sx, sy]) => svg("circle", { class: "seen", cx: sx, cy: -sy })),
      drone,
    );
    this.layers.view.replaceChildren(svg("path", { d: view ? this.squares(bits(view, this.rows * this.columns)) : "" }));
  }

  setCursor(cell) {
    this.cursor = cell;
    if (cell == null) return this.layers.cursor.replaceChildren();
    const { cell_m: s, cells_extent_m: [west, south] } = this.scene;
    const x = west + (cell % this.columns) * s, y = -(south + Math.floor(cell / this.columns) * s) - s;
    this.layers.cursor.replaceChildren(svg("rect", { x, y, width: s, height: s, class: "halo" }), svg("rect", { x, y, width: s, height: s }));
  }

  // Pointer and keys

  toMetres(event) {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.root.getScreenCTM().inverse());
    return [point.x, -point.y];
  }

  inside([x, y]) {
    const [west, south, east, north] = this.scene.extent_m;
    return [Math.min(Math.max(x, west), east), Math.min(Math.max(y, south), north)];
  }

  listen() {
    const drags = () => this.tool === "area" || this.tool === "arrow";
    let from = null, moved = false, screen = null;
    this.root.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      from = this.toMetres(event);
      screen = [event.clientX, event.clientY];
      moved = false;
      if (drags()) this.root.setPointerCapture(event.pointerId);
    });
    this.root.addEventListener("pointermove", (event) => {
      const at = this.toMetres(event);
      this.on.hover?.(this.cellOf(...at));
      if (this.corners.length) this.drawDraft(this.inside(at));
      if (!from) return;
      moved ||= Math.hypot(event.clientX - screen[0], event.clientY - screen[1]) > 4;
      if (!moved) return;
      if (this.tool === "area") this.setArea(this.areaBetween(from, at));
      else if (this.tool === "arrow") this.on.drag?.(this.inside(from), this.inside(at), false);
      else if (event.pointerType === "mouse") this.pan(from[0] - at[0], at[1] - from[1]);
    });
    this.root.addEventListener("pointerup", (event) => {
      if (!from) return;
      const at = this.toMetres(event), start = from;
      from = null;
      if (moved && this.tool === "area") this.on.area?.(this.areaBetween(start, at));
      else if (moved && this.tool === "arrow") this.on.drag?.(this.inside(start), this.inside(at), true);
      else if (!moved && this.cellOf(...at) != null) {
        this.setCursor(this.cellOf(...at));
        this.use(this.inside(at), event);
      }
    });
    this.root.addEventListener("pointercancel", () => { from = null; });
    this.root.addEventListener("pointerleave", () => {
      this.on.hover?.(null);
      if (this.corners.length) this.drawDraft();
    });
    this.root.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.metaKey && document.activeElement !== this.root) return; // the page scrolls
      event.preventDefault();
      const [x, y] = this.toMetres(event);
      this.zoom(event.deltaY > 0 ? 1.2 : 1 / 1.2, [x, -y]);
    }, { passive: false });
    this.root.addEventListener("keydown", (event) => this.key(event));
  }

  use(at, event) {
    if (this.tool === "polygon") this.addCorner(at, event.type === "keydown" ? this.scene.cell_m / 2 : undefined);
    else this.on.pick?.(at, event);
  }

  areaBetween(a, b) {
    const [[x0, y0], [x1, y1]] = [this.inside(a), this.inside(b)];
    return [Math.min(x0, x1), Math.min(y0, y1), Math.max(x0, x1), Math.max(y0, y1)].map((v) => Math.round(v * 10) / 10);
  }

  key(event) {
    const moves = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (this.tool === "arrow") return; // its page has keys of its own
    if (moves[event.key]) {
      const step = event.shiftKey ? 5 : 1, [dr, dc] = moves[event.key];
      const at = this.cursor ?? Math.floor(this.rows / 2) * this.columns + Math.floor(this.columns / 2);
      const row = Math.min(Math.max(Math.floor(at / this.columns) + dr * step, 0), this.rows - 1);
      const column = Math.min(Math.max((at % this.columns) + dc * step, 0), this.columns - 1);
      this.setCursor(row * this.columns + column);
      this.reveal(this.centreOf(this.cursor));
      this.on.cell?.(this.cursor);
    } else if (event.key === "Enter" || event.key === " ") {
      if (this.cursor != null) this.use(this.centreOf(this.cursor), event);
    } else if (this.corners.length && event.key === "Backspace") {
      this.dropCorners(1);
    } else if (this.corners.length && event.key === "Escape") {
      this.dropCorners(this.corners.length);
    } else if (event.key === "+" || event.key === "=") this.zoom(1 / 1.4);
    else if (event.key === "-") this.zoom(1.4);
    else if (event.key === "0") this.zoomTo(this.whole);
    else if (!this.on.key?.(event)) return;
    event.preventDefault();
  }

  /** Pan until a place is on the screen. */
  reveal([x, y]) {
    const [bx, by, bw, bh] = this.box, edge = 2 * this.scene.cell_m;
    const dx = Math.min(x - edge - bx, 0) + Math.max(x + edge - bx - bw, 0);
    const dy = Math.min(-y - edge - by, 0) + Math.max(-y + edge - by - bh, 0);
    if (dx || dy) this.pan(dx, dy);
  }
}

/** Plays the steps of a search on a view: play, pause, back, forward, speed. */
export class Player {
  constructor(element, view, { announce = () => {}, shown = () => {} } = {}) {
    Object.assign(this, { view, announce, shown, steps: [], at: 0, playing: false });
    this.button = html("button", { type: "button", class: "play", onclick: () => this.toggle() }, "Play");
    this.slider = html("input", { type: "range", min: 0, max: 0, value: 0, "aria-label": "Step of the search",
      oninput: () => { this.pause(); this.show(Number(this.slider.value)); } });
    this.speed = html("select", { "aria-label": "Speed" },
      ...[["0.5", "half speed"], ["1", "normal speed"], ["2", "double speed"], ["6", "fast"]].map(([value, text]) => html("option", { value, selected: value === "1" }, text)));
    this.line = html("p", { class: "step-line" });
    this.values = html("ul", { class: "step-values" });
    element.replaceChildren(
      html("div", { class: "player-row" },
        html("button", { type: "button", "aria-label": "First step", onclick: () => { this.pause(); this.show(0); } }, "|◀"),
        html("button", { type: "button", "aria-label": "One step back", onclick: () => { this.pause(); this.show(this.at - 1); } }, "◀"),
        this.button,
        html("button", { type: "button", "aria-label": "One step on", onclick: () => { this.pause(); this.show(this.at + 1); } }, "▶"),
        this.slider, this.speed),
      this.line, this.values);
  }

  /** Begin a search: its places, its start, and the beliefs before the first step. */
  begin(places, pose, beliefs, target) {
    this.steps = [{ pose, places, beliefs, found: [], view: null, plan: [], seen: {}, values: {} }];
    Object.assign(this, { places, target, ended: null });
    this.slider.max = 0;
    this.show(0);
  }

  add(step) {
    this.steps.push(step);
    this.slider.max = this.steps.length - 1;
  }

  end(outcome) {
    this.ended = outcome;
    if (this.at === this.steps.length - 1) this.show(this.at);
  }

  show(at) {
    this.at = Math.min(Math.max(at, 0), this.steps.length - 1);
    const step = this.steps[this.at];
    if (!step) return;
    this.slider.value = this.at;
    const belief = step.beliefs[this.target] ?? Object.values(step.beliefs)[0];
    if (belief) {
      this.view.setValues(numbers(belief));
      this.view.setContours([{ mask: belief.hpd90, name: "hpd90" }]);
    }
    this.view.setDrone(this.steps.slice(0, this.at + 1).map((one) => one.pose), step.view, step.plan, step.seen);
    this.view.setMarks(this.places);
    const last = this.at === this.steps.length - 1 && this.ended;
    this.line.textContent = this.words(step) + (last ? ` ${this.ended.found ? "Found." : "Not found."}` : "");
    this.slider.setAttribute("aria-valuetext", this.line.textContent);
    const best = Math.max(...Object.values(step.values));
    this.values.setAttribute("aria-label", "Expected value of each move");
    this.values.replaceChildren(...Object.entries(step.values).map(([name, value]) =>
      html("li", { class: value === best ? "best" : "" }, html("span", {}, name), ` ${value.toFixed(0)}`)));
    if (!this.playing || last) this.announce(this.line.textContent);
    this.shown(this.at, step);
  }

  words(step) {
    if (!this.at) return "Before the first step.";
    const action = { forward: "flies on", left: "turns left", right: "turns right" }[step.action] ?? (step.reward > 0 ? "looks closer and is right" : "looks closer and is wrong");
    const seen = Object.keys(step.seen);
    return `Step ${this.at}: the drone ${action}${step.collision ? `, hits ${step.collision}` : ""}${seen.length ? `, sees ${seen.join(", ")}` : ""}.${step.found.length ? ` Found so far: ${step.found.join(", ")}.` : ""}`;
  }

  toggle() { this.playing ? this.pause() : this.play(); }

  play() {
    if (this.at >= this.steps.length - 1 && this.ended) this.show(0);
    this.playing = true;
    this.button.textContent = "Pause";
    this.tick();
  }

  tick() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      if (!this.playing) return;
      if (this.at < this.steps.length - 1) this.show(this.at + 1);
      if (this.at >= this.steps.length - 1 && this.ended) this.pause();
      else this.tick();
    }, 420 / Number(this.speed.value));
  }

  pause() {
    this.playing = false;
    this.button.textContent = "Play";
    clearTimeout(this.timer);
  }
}

/** Show what was kept: a page of its own without a server, or a cell of a notebook. */
export function show(element, data, on = {}) {
  element.classList.add("sloop");
  const live = html("p", { class: "live", role: "status" });
  const said = html("p", { class: "said" });
  said.textContent = data.text ? `“${data.text}”` : "";
  const frame = html("div", { class: "map-frame" }), below = html("div", { class: "player" });
  const read = html("p", { class: "readout", "aria-hidden": "true" });
  const choices = html("div", { class: "targets", role: "group", "aria-label": "Target" });
  element.replaceChildren(said, choices, frame, read, live, below);
  let target = null, player = null;
  const view = new CityView(frame, data.scene, data.colours, {
    ...on,
    hover: (cell) => { read.textContent = cell == null || !view.values ? "" : percent(view.values[cell]); },
    cell: (cell) => { live.textContent = view.values ? percent(view.values[cell]) : ""; },
    pick: (at) => {
      if (view.tool !== "look") on.pick?.(at, target?.id, view.tool === "there");
      if (view.tool !== "look") view.setEvidence((drawn = [...drawn, { at, radius_m: 2 * data.scene.cell_m, is_there: view.tool === "there" }]));
    },
    area: (area) => {
      view.setArea(area);
      on.area?.(area);
    },
  });
  let drawn = [];
  if (on.pick) {
    const tools = { look: "Look", absent: "Not here", there: "Seen here", area: "Area", polygon: "Polygon" };
    const row = html("div", { class: "targets", role: "group", "aria-label": "Tool" }, ...Object.entries(tools).map(([key, text]) =>
      html("button", { type: "button", "aria-pressed": key === "look", onclick: (event) => {
        view.tool = frame.dataset.tool = key;
        view.dropCorners(view.corners.length);
        for (const button of row.children) button.setAttribute("aria-pressed", button === event.target);
      } }, text)));
    frame.before(row);
    for (const question of data.questions ?? []) {
      below.before(html("p", {}, `${question.text} `, ...question.answers.map((one) =>
        html("button", { type: "button", onclick: () => on.answer?.(question.text, one.text) }, one.text))));
    }
  }
  view.root.setAttribute("aria-label", `Map of ${data.scene.name}`);
  const choose = (one) => {
    target = one;
    view.setValues(numbers(one.belief));
    view.setContours([{ mask: one.hpd90, name: "hpd90" }, { mask: one.hpd50, name: "hpd50" }]);
    view.mention(one.referents.flatMap((r) => r.candidates.filter((c) => c.ground && c.p > 0.1).map((c) => c.ground)));
    view.setFrames(data.frames?.[one.id] ?? []);
    live.textContent = one.spoken;
    if (player) { player.target = one.id; player.show(player.at); }
    for (const button of choices.children) button.setAttribute("aria-pressed", button.dataset.id === one.id);
  };
  const targets = data.belief.targets;
  if (targets.length > 1) {
    choices.append(...targets.map((one) => html("button", { type: "button", "data-id": one.id, onclick: () => choose(one) }, one.id)));
  }
  if (data.search) {
    player = new Player(below, view, { announce: (text) => { live.textContent = text; } });
    const before = Object.fromEntries(targets.map((one) => [one.id, { ...one.belief, hpd90: one.hpd90 }]));
    choose(targets[0]);
    player.begin(data.search.places, data.search.pose, data.search.beliefs ?? before, targets[0].id);
    data.search.steps.forEach((step) => player.add(step));
    player.end(data.search);
  } else choose(targets[0]);
  return { view, player, target: () => target };
}

/** The contract of anywidget. */
function render({ model, el }) {
  const send = (name, value) => { model.set(name, value); model.save_changes(); };
  const draw = () => {
    const data = model.get("payload");
    if (!data?.scene) return;
    show(el, data, {
      pick: (at, target, is_there) => send("picked", { at, target, is_there }),
      area: (area) => send("area", area),
      answer: (question, answer) => send("answer", { question, answer }),
    });
  };
  model.on("change:payload", draw);
  draw();
}

export default { render };
