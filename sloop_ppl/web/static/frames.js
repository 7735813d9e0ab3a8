// Annotating frames of reference: which way a place faces when someone says "in front of it".
import { CityView, html, svg } from "./view.js";
import { announce, ask, by, get, options, problem, theme, trying } from "./page.js";

const LENGTH_PX = 90;
let queue, scenes = {}, colours, view, item, at = 0, origin, angle = null, drawn = false, moving = false, began = 0;

const annotator = () => by("annotator").value.trim();

async function load(map) {
  const query = new URLSearchParams({ annotator: annotator(), ...(map ? { map } : {}) });
  queue = await get(`/api/frames/queue?${query}`);
  options(by("map"), queue.maps.map((m) => [m.key, m.name]), queue.map);
  by("map").disabled = queue.own_queue;
  by("file").textContent = queue.file;
  const first = queue.items.findIndex((one) => !(one.id in queue.done));
  // An arrow that was drawn before the name was entered stays; that of another annotator does not.
  const kept = drawn ? { id: item.id, origin, angle } : null;
  await go(first < 0 ? 0 : first);
  if (kept?.id === item.id && !(item.id in queue.done)) {
    ({ origin, angle } = kept);
    drawn = true;
    draw();
  }
}

async function go(to) {
  at = Math.min(Math.max(to, 0), queue.items.length - 1);
  item = queue.items[at];
  const scene = (scenes[item.map] ??= await get(`/api/map/${encodeURIComponent(item.map)}`));
  if (view?.scene !== scene) {
    by("map-a").replaceChildren();
    view = new CityView(by("map-a"), scene, colours, {
      pick: (place) => { if (moving) begins(place); else point(place); },
      drag: (from, place) => { begins(from); point(place); },
      key,
    });
    view.tool = "arrow";
    view.root.setAttribute("aria-label", `Map of ${scene.name}`);
    by("attribution").textContent = scene.attribution;
    new ResizeObserver(draw).observe(view.root);
  }
  const ground = scene.landmarks.find((one) => one.id === item.ground);
  view.mention([item.ground]);
  view.setCursor(null);
  view.zoomTo(view.whole);
  by("phrase").replaceChildren(`“${item.text}”`);
  by("ground").textContent = `The outlined place is ${ground.name ?? ground.id}.`;
  const done = queue.done[item.id];
  origin = done?.origin ?? ground.at;
  angle = done?.end ? Math.atan2(done.end[1] - origin[1], done.end[0] - origin[0]) : null;
  drawn = moving = false;
  began = performance.now();
  problem("");
  draw();
  const count = Object.keys(queue.done).length;
  by("count").textContent = `Phrase ${at + 1} of ${queue.items.length}; ${count} done${done ? (done.unclear ? "; this one is unclear" : "; this one is done") : ""}.`;
  announce(`${item.text}. ${by("ground").textContent}`);
}

function begins(place) { origin = place; moving = false; draw(); }

function point(place) {
  angle = Math.atan2(place[1] - origin[1], place[0] - origin[0]);
  drawn = true;
  draw();
}

function turn(degrees) {
  angle = (angle ?? Math.PI / 2) + (angle === null ? 0 : (degrees * Math.PI) / 180);
  drawn = true;
  draw();
  announce(by("angle").textContent);
}

const COMPASS = ["east", "northeast", "north", "northwest", "west", "southwest", "south", "southeast"];

function draw() {
  const layer = view.layers.frames, px = view.metresPerPixel ?? 0.3, length = LENGTH_PX * px;
  const vector = (name, turned, size) => {
    const node = svg("g", { transform: `translate(${origin[0]} ${-origin[1]}) rotate(${(-(angle + turned) * 180) / Math.PI})` });
    node.append(svg("path", { class: `vector vector-${name}`, d: `M0 0H${size}m${-10 * px} ${-6 * px}l${10 * px} ${6 * px}l${-10 * px} ${6 * px}` }));
    return node;
  };
  layer.replaceChildren(
    ...(angle === null ? [] : [vector("right", -Math.PI / 2, length * 0.6), vector("front", 0, length)]),
    svg("circle", { class: "origin", cx: origin[0], cy: -origin[1] }),
  );
  by("save").disabled = angle === null || !annotator();
  const degrees = angle === null ? null : ((angle * 180) / Math.PI + 360) % 360;
  by("angle").textContent = angle === null ? "No arrow yet." : `Front: ${degrees.toFixed(0)}° from east, towards ${COMPASS[Math.round(degrees / 45) % 8]}.${annotator() ? "" : " Enter your name to save."}`;
}

function key(event) {
  const turns = { ArrowLeft: 5, ArrowUp: 5, ArrowRight: -5, ArrowDown: -5 };
  if (event.key in turns) { turn(event.shiftKey ? turns[event.key] / 5 : turns[event.key]); return true; }
  if (event.key === "Enter") { save(); return true; }
  return false;
}

async function save(unclear = false) {
  if (!annotator()) {
    problem("Enter your name first; annotators are told apart by it.");
    by("annotator").focus();
    return;
  }
  if (!unclear && angle === null) return;
  const end = unclear ? null : [origin[0] + 20 * Math.cos(angle), origin[1] + 20 * Math.sin(angle)];
  await trying(async () => {
    await ask("/api/frames/annotations", {
      item: item.id, annotator: annotator(), map: queue.own_queue ? null : item.map,
      origin: unclear ? null : origin, end, seconds: (performance.now() - began) / 1000,
    });
    queue.done[item.id] = { unclear, origin: unclear ? null : origin, end };
    await go(at + 1);
    if (Object.keys(queue.done).length === queue.items.length) by("count").textContent = `All ${queue.items.length} phrases are done. Thank you.`;
  });
}

function moveOrigin() {
  moving = true;
  view.setCursor(view.cellOf(...origin));
  announce("Arrows move where it begins; Enter sets it.");
}

async function begin() {
  theme();
  document.querySelectorAll(".vector-key").forEach((node) => node.prepend(html("i", {})));
  by("annotator").value = localStorage.getItem("sloop-annotator") ?? "";
  const start = await get("/api/start").catch((error) => { problem(error.message); throw error; });
  colours = start.colours;
  await trying(() => load());
  by("annotator").addEventListener("change", () => {
    localStorage.setItem("sloop-annotator", annotator());
    trying(() => load(queue.own_queue ? null : queue.map));
  });
  by("annotator").addEventListener("input", draw);
  by("map").addEventListener("change", () => trying(() => load(by("map").value)));
  by("save").addEventListener("click", () => save());
  by("unclear").addEventListener("click", () => save(true));
  by("skip").addEventListener("click", () => go(at + 1));
  by("back").addEventListener("click", () => go(at - 1));
  // Keys work wherever the focus is, but in fields; the map's own come first when it has it.
  document.addEventListener("keydown", (event) => {
    if (event.target.matches("input, select, textarea") || event.ctrlKey || event.metaKey || event.altKey) return;
    const onMap = event.target === view.root, button = event.target.matches("button, a");
    if (moving) {
      const steps = { ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [-1, 0], ArrowRight: [1, 0] }[event.key];
      if (steps) origin = view.inside([origin[0] + steps[0], origin[1] + steps[1]]);
      else if (event.key === "Enter" || event.key === "Escape") { moving = false; view.setCursor(null); }
      else return;
      event.preventDefault();
      event.stopPropagation();
      draw();
    } else if (event.key.toLowerCase() === "u") save(true);
    else if (event.key.toLowerCase() === "s") go(at + 1);
    else if (event.key.toLowerCase() === "b") go(at - 1);
    else if (event.key.toLowerCase() === "o") moveOrigin();
    else if (!onMap && !(button && event.key === "Enter") && key(event)) event.preventDefault();
    else if (onMap && key(event)) { event.preventDefault(); event.stopPropagation(); }
  }, true);
  document.addEventListener("theme", () => view?.repaint());
  document.body.dataset.ready = "true";
}

begin();
