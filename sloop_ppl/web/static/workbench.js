// The workbench: a sentence, the belief that follows from it, and the search.
import { CityView, Player, html, numbers, percent } from "./view.js";
import { Refused, announce, ask, by, download, events, get, options, post, problem, theme, trying } from "./page.js";

const BELIEF = ["map", "text", "model", "variant", "frames", "prior", "viewpoint", "off", "evidence", "area", "answers", "polygon", "parameters"];
const BLANK = {
  map: "", text: "", model: "bayes", variant: "published", frames: null, prior: null, viewpoint: "map",
  off: [], evidence: [], area: null, polygon: null, answers: [], parameters: {}, compare: "", places: {}, start: null, planner: "fast",
  seed: 0, range: 3, steps: 200, sayings: {}, target: "", layer: "belief",
};
const TOOLS = {
  look: "Look", absent: "Not here", there: "Seen here", area: "Area", polygon: "Polygon", place: "True place", start: "Start",
};
const TOOL_TITLES = {
  look: "What the belief is there", absent: "Someone looked there: it is not there", there: "Someone saw it there",
  area: "Search only within a rectangle: drag it", polygon: "Search only within a polygon: click its corners, the first one again to end",
  place: "Where it truly is, which the drone does not know", start: "Where the drone begins",
};
const MOST_EPISODE_BYTES = 24 * 2 ** 20;
const LAYERS = { belief: "Belief", prior: "Before", change: "Change" };
const KEYS = { n: "absent", s: "there", p: "place", b: "start", a: "area", o: "polygon" };

let start, state, scene, view, other, player, shown, compared, frames = {}, corner = null, episode = null;
let drawnParameters = "";
let undone = [], busy = new AbortController(), searching = null;

const asked = (extra = {}) => ({ ...Object.fromEntries(BELIEF.map((key) => [key, state[key]])), ...extra });
const target = () => shown?.belief?.targets.find((one) => one.id === state.target);

// State, undo, address

/** Change the state as one step that can be undone. */
function change(changes) {
  undone.push(JSON.stringify(state));
  undone = undone.slice(-200);
  state = { ...state, ...changes };
  return update();
}

function remember() {
  const kept = Object.fromEntries(Object.entries(state).filter(([key, value]) => JSON.stringify(value) !== JSON.stringify(BLANK[key])));
  history.replaceState(null, "", `#${encodeURIComponent(JSON.stringify(kept))}`);
  by("undo").disabled = !undone.length;
}

function fromAddress() {
  try {
    const given = JSON.parse(decodeURIComponent(location.hash.slice(1)));
    const known = Object.keys(BLANK).filter((key) => key in given && sameKind(given[key], BLANK[key]));
    return known.length ? Object.fromEntries(known.map((key) => [key, given[key]])) : null;
  } catch { return null; }
}

const sameKind = (a, b) => b === null ? true : Array.isArray(a) === Array.isArray(b) && typeof a === typeof b && a !== null;

async function undo() {
  if (!undone.length) return;
  const map = state.map;
  state = JSON.parse(undone.pop());
  if (state.map !== map) await showMap();
  by("text").value = state.text;
  await update();
}

// Reading and belief

async function update() {
  remember();
  controls();
  endSearch();
  busy.abort();
  const mine = (busy = new AbortController());
  working(true);
  await trying(async () => {
    const found = await ask("/api/belief", asked(), mine.signal);
    show(found);
    compared = null;
    if (state.compare && found.belief) compared = await ask("/api/belief", asked({ model: state.compare, parameters: {} }), mine.signal);
    showMaps();
    await later(mine.signal);
  });
  if (busy === mine) working(false);
}

const working = (on) => by("maps").setAttribute("aria-busy", String(on));

/** What takes longer than the belief: frames, why, questions. */
async function later(signal) {
  frames = {};
  if (!shown.belief) return showFrames();
  frames = await ask("/api/frames-of", asked(), signal);
  showFrames();
  if (by("why-box").open) await why(null, signal);
  if (by("questions-box").open) await questions(signal);
}

/** Questions take longest of all: they are looked for only where they are shown. */
async function questions(signal) {
  if (shown.belief) showQuestions((await ask("/api/questions", asked(), signal)).questions);
}

function show(found) {
  shown = found;
  problem(found.problem);
  const targets = found.belief?.targets ?? [];
  if (!targets.some((one) => one.id === state.target)) {
    state.target = targets[0]?.id ?? "";
    remember();
  }
  showReading(found.reading);
  showTargets(targets);
  showMaps();
  showMeant();
  by("search").disabled = !targets.length;
  document.querySelectorAll("[data-export], #page").forEach((button) => { button.disabled = !targets.length; });
}

function showReading(reading) {
  const marks = [], text = state.text;
  let at = 0;
  for (const mark of reading?.spans ?? []) {
    const [from, to] = mark.span;
    marks.push(text.slice(at, from));
    const sure = mark.confidence == null ? "" : mark.confidence > 0.9 ? "sure" : mark.confidence > 0.5 ? "likely" : "unsure";
    marks.push(html("mark", { class: `${mark.role} ${mark.status} ${sure} ${state.off.includes(mark.phrase) ? "off" : ""}` }, text.slice(from, to)));
    at = to;
  }
  by("marks").replaceChildren(...marks, text.slice(at), "\n");
  const several = new Set(reading?.phrases.map((one) => one.figure)).size > 1;
  by("phrases").replaceChildren(...(reading?.phrases ?? []).map((one) => {
    const box = html("input", { type: "checkbox", checked: !state.off.includes(one.index),
      onchange: () => change({ off: box.checked ? state.off.filter((i) => i !== one.index) : [...state.off, one.index] }) });
    const open = one.candidates.filter((slot) => slot.length > 1);
    const rest = html("span", { class: "alternatives" }, ...open.map((slot) =>
      html("span", {}, slot.map((c) => `${c.label} ${percent(c.p)}`).join(", "))));
    return html("li", { class: `${one.negated ? "denied" : ""} ${one.confidence < 0.5 ? "unsure" : ""}`, tabindex: open.length ? "0" : null },
      html("label", {}, box, html("span", {}, `${several ? `${one.figure}: ` : ""}${one.text}`),
        html("span", { class: "sure", title: "how surely this was read right" }, percent(one.confidence))),
      open.length ? rest : null);
  }));
  const status = { unknown: "not understood", asked: "a question", retracted: "taken back", past: "of the past", route: "a way", other: "about something else" };
  by("unread").replaceChildren(...(reading?.unresolved ?? []).map((one) =>
    html("li", {}, html("b", {}, `“${one.text}”`), ` ${status[one.status] ?? one.status}`,
      one.candidates.length ? html("span", { class: "alternatives" }, `nearest: ${one.candidates.join(", ")}`) : null)));
}

function showTargets(targets) {
  by("targets").replaceChildren(...targets.map((one, i) => radio("target", one.id, one.id, state.target, (id) => {
    state.target = id;
    remember();
    showMaps();
    showFrames();
    showMeant();
    if (by("why-box").open) trying(() => why());
  }, `target-${i % 6}`)));
  for (const one of targets) if (one.id === state.target) where(one);
  if (!targets.length) by("where").textContent = "";
}

function where(one) {
  by("where").textContent = `${one.spoken}. Likeliest: ${one.where}; nine tenths lie within ${Math.round(one.hpd90_m2).toLocaleString("en")} m².`;
  announce(one.spoken);
}

function tableOf(one, layer) {
  const belief = numbers(one.belief);
  if (layer === "belief") return belief;
  const prior = one.prior ? numbers(one.prior) : belief.map(() => 1 / belief.length);
  return layer === "prior" ? prior : belief.map((p, i) => p - prior[i]);
}

function showMaps() {
  const one = target(), two = compared?.belief?.targets.find((t) => t.id === state.target);
  by("map-b").hidden = !two;
  by("maps").classList.toggle("two", Boolean(two));
  if (!view) return;
  view.setArea(state.polygon ?? state.area);
  view.setEvidence(state.evidence.filter((e) => e.target === state.target));
  view.setMarks(state.places, state.start);
  if (!one) {
    view.setValues(null);
    view.setContours([]);
    view.mention([]);
    return;
  }
  where(one);
  const changed = Object.keys(state.parameters).length ? `${shown.belief.model}, changed` : shown.belief.model;
  const difference = two && state.layer === "change";
  const values = difference ? numbers(one.belief).map((p, i) => p - numbersOf(two)[i]) : tableOf(one, state.layer);
  draw(view, one, values, state.layer === "change");
  by("caption-a").textContent = difference ? `${changed} minus ${compared.belief.model}` : two ? changed : "";
  if (two) {
    other ??= new CityView(by("map-b"), scene, start.colours, { hover: readout });
    other.root.setAttribute("aria-label", `Map of ${scene.name}, model ${compared.belief.model}`);
    draw(other, two, tableOf(two, state.layer === "prior" ? "prior" : "belief"), false);
    by("caption-b").textContent = compared.belief.model;
  }
  by("legend-low").textContent = state.layer === "change" ? "less" : "least";
  by("legend-high").textContent = state.layer === "change" ? "more" : "most";
  by("legend-bar").className = `bar ${state.layer === "change" ? "difference" : ""}`;
}

let cached = [null, null];
function numbersOf(one) {
  if (cached[0] !== one) cached = [one, numbers(one.belief)];
  return cached[1];
}

function draw(on, one, values, difference) {
  on.setValues(values, { difference });
  on.setContours([{ mask: one.hpd90, name: "hpd90" }, { mask: one.hpd50, name: "hpd50" }]);
  on.mention(one.referents.flatMap((r) => r.candidates.filter((c) => c.ground && c.p > 0.1).map((c) => c.ground)));
}

function showFrames() {
  view?.setFrames(frames[state.target] ?? []);
  if (other) other.setFrames([]);
}

const bar = (p) => {
  const node = html("span", { class: "share" });
  node.style.setProperty("--p", p);
  return node;
};

function showMeant() {
  const one = target();
  if (!one) return by("meant").replaceChildren();
  const rows = (title, entries) => entries.length ? [html("h3", {}, title), html("ul", { class: "shares" }, ...entries.map(([text, p, title2]) =>
    html("li", { title: title2 ?? null }, html("span", {}, text), bar(p), html("span", { class: "p" }, percent(p)))))] : [];
  by("meant").replaceChildren(
    ...one.referents.flatMap((r) => r.candidates.length > 1 ? rows(`Which place is meant (${r.phrase})`, r.candidates.map((c) => [c.label, c.p])) : []),
    ...rows("How it was spoken", one.components.map((c) => [c.name, c.p, `before the map was asked: ${percent(c.prior)}`])),
    ...(shown.reading.readings.length > 1 ? rows("Ways to read it", shown.reading.readings.map((r) => [r.text, r.p])) : []),
  );
}

async function why(at = null, signal) {
  const one = target();
  if (!one) return by("why").replaceChildren();
  const found = await ask("/api/why", { state: asked(), target: one.id, at }, signal);
  const most = Math.max(...found.phrases.map((p) => p.bits), 1e-9);
  by("why").replaceChildren(
    html("ul", { class: "shares" }, ...found.phrases.map((p) => html("li", {},
      html("span", {}, p.text), bar(p.bits / most),
      html("span", { class: "p" }, `${p.bits.toFixed(2)} bits${p.times == null ? "" : `, ×${p.times < 10 ? p.times.toFixed(2) : p.times.toFixed(0)} here`}`)))),
    at ? html("p", { class: "small" }, `${found.where}: ${percent(found.p)}${found.components ? `; ${Object.entries(found.components).map(([k, v]) => `${k} ${percent(v)}`).join(", ")}` : ""}`) : null ?? "",
  );
}

function showQuestions(found) {
  by("questions").replaceChildren(
    ...state.answers.map(([question, reply], i) => html("p", { class: "small" }, `${question} ${reply} `,
      html("button", { type: "button", onclick: () => change({ answers: state.answers.slice(0, i) }) }, "Take back"))),
    ...found.map((q) => html("div", { class: "question" }, html("p", {}, q.text, html("span", { class: "small" }, ` ${q.bits.toFixed(2)} bits`)),
      html("p", { class: "row wrap" }, ...q.answers.map((a) => html("button", { type: "button",
        onclick: () => change({ answers: [...state.answers, [q.text, a.text]] }) }, `${a.text} (${percent(a.p)})`))))),
  );
}

// Tools

function use(tool, at) {
  const [x, y] = at.map((v) => Math.round(v * 100) / 100);
  if (tool === "look") {
    say(view.cursor);
    if (target() && by("why-box").open) trying(() => why([x, y]));
  } else if (tool === "absent" || tool === "there") {
    if (target()) change({ evidence: [...state.evidence, { target: state.target, at: [x, y], radius_m: 2 * scene.cell_m, is_there: tool === "there" }] });
  } else if (tool === "place") change({ places: { ...state.places, [state.target || "GreenToyota"]: [x, y] } });
  else if (tool === "start") change({ start: [x, y] });
  else if (tool === "polygon") view.addCorner([x, y], scene.cell_m / 2);
  else if (tool === "area") {
    if (!corner) {
      corner = [x, y];
      announce("One corner is set; go to the other and press Enter.");
    } else {
      const area = view.areaBetween(corner, [x, y]);
      corner = null;
      if (area[2] - area[0] > 0 && area[3] - area[1] > 0) change({ area, polygon: null });
    }
  }
}

/** How the drawing of a polygon goes on. */
function cornerSet(count) {
  announce(count < 3
    ? `${count} corner${count > 1 ? "s are" : " is"} set; set ${3 - count} more at least. Escape gives up, Backspace takes the last one back.`
    : `${count} corners are set; use the first or the last one again to end.`);
}

function say(cell) {
  if (cell == null || !view.values) return;
  readout(cell);
  announce(`${percent(view.values[cell])} in this cell`);
}

function readout(cell) {
  const values = view?.values;
  by("readout").textContent = cell == null || !values ? "" : percent(values[cell]);
}

function showEvidence() {
  const drop = (text, changes) => html("li", {}, html("span", {}, text), html("button", { type: "button", "aria-label": `Remove: ${text}`, onclick: () => change(changes) }, "Remove"));
  const place = ([x, y]) => `${Math.abs(Math.round(x))} m ${x < 0 ? "west" : "east"}, ${Math.abs(Math.round(y))} m ${y < 0 ? "south" : "north"} of the middle`;
  const items = [
    ...state.evidence.map((e, i) => drop(`${e.target} ${e.is_there ? "seen" : "is not"} at ${place(e.at)}`, { evidence: state.evidence.filter((_, j) => j !== i) })),
    ...(state.area || state.polygon ? [drop("Search area", { area: null, polygon: null })] : []),
    ...Object.entries(state.places).map(([name, at]) => drop(`${name} truly is ${place(at)}`, { places: Object.fromEntries(Object.entries(state.places).filter(([n]) => n !== name)) })),
    ...(state.start ? [drop(`The drone begins ${place(state.start)}`, { start: null })] : []),
  ];
  by("evidence").replaceChildren(...items);
  by("evidence-count").textContent = items.length ? `(${items.length})` : "";
}

function radio(group, value, text, chosen, choose, style = "", title = null) {
  const input = html("input", { type: "radio", name: group, value, checked: value === chosen, onchange: () => choose(value) });
  return html("label", { class: style, title }, input, html("span", {}, text));
}

// Parameters of the model

/** Sliders for the numbers of the model, made anew only for another model. */
async function showParameters() {
  if (!by("model-box").open) return;
  const key = `${encodeURIComponent(state.model)}?variant=${encodeURIComponent(state.variant)}`;
  if (drawnParameters !== key) {
    drawnParameters = key;
    const found = (await get(`/api/parameters/${key}`)).parameters;
    if (drawnParameters !== key) return; // another model was chosen meanwhile
    const titles = { weights: "Components", likelihood: "Relations", frames: "Fronts", model: "Whole model" };
    const sections = Object.keys(titles).map((section) => [section, found.filter((one) => one.section === section)]);
    by("parameters").replaceChildren(...sections.filter(([, list]) => list.length).map(([section, list]) =>
      html("fieldset", { class: "parameters" }, html("legend", {}, titles[section]), ...list.map(parameterRow))));
  }
  for (const row of document.querySelectorAll("#parameters [data-name]")) {
    row.show(state.parameters[row.dataset.section]?.[row.dataset.name]);
  }
  by("reset").disabled = !Object.keys(state.parameters).length;
}

const inWords = ({ name, unit }) => `${name.replace(/_m$/, "").replaceAll("_", " ")}${unit === "m" ? ", m" : ""}`;
const brief = (value) => Number(value.toPrecision(3));

function parameterRow(one) {
  const attributes = { class: "parameter", "data-section": one.section, "data-name": one.name, title: one.meaning };
  let row;
  if (one.high == null) {
    const box = html("input", { type: "checkbox", onchange: () => setParameter(one, box.checked) });
    row = html("label", attributes, html("span", {}, inWords(one)), box);
    row.show = (value) => { box.checked = value ?? one.value; };
  } else {
    const range = { min: one.low, max: one.high, step: "any" };
    const slider = html("input", { type: "range", ...range, "aria-label": `${inWords(one)}: ${one.meaning}`,
      oninput: () => { number.value = brief(Number(slider.value)); setParameter(one, inRange(one, Number(number.value)), true); },
      onchange: () => { sliding = false; } });
    const number = html("input", { type: "number", ...range, "aria-label": inWords(one),
      onchange: () => { if (number.reportValidity()) setParameter(one, Number(number.value)); } });
    row = html("div", attributes, html("span", {}, inWords(one)), slider, number);
    row.show = (value) => {
      slider.value = value ?? one.value;
      if (document.activeElement !== number) number.value = brief(value ?? one.value);
    };
  }
  const show = row.show;
  row.show = (value) => {
    show(value);
    row.classList.toggle("changed", value !== undefined);
  };
  return row;
}

const inRange = (one, value) => Math.min(Math.max(value, one.low), one.high);
let sliding = false, slid = null;

/** A drag of a slider is one step that can be undone. */
function setParameter({ section, name, value: own }, value, isSliding = false) {
  const { [name]: _, ...others } = state.parameters[section] ?? {};
  const { [section]: __, ...sections } = state.parameters;
  const numbers = value === own ? others : { ...others, [name]: value };
  const parameters = Object.keys(numbers).length ? { ...sections, [section]: numbers } : sections;
  if (!isSliding) return change({ parameters });
  if (!sliding) undone.push(JSON.stringify(state));
  sliding = true;
  state = { ...state, parameters };
  working(true);
  clearTimeout(slid);
  slid = setTimeout(update, 25);
}

function controls() {
  for (const name of ["model", "compare", "variant", "viewpoint", "planner"]) by(name).value = state[name];
  for (const name of ["frames", "prior"]) by(name).value = state[name] ?? "";
  for (const name of ["range", "steps", "seed"]) by(name).value = state[name];
  by("map").value = state.map;
  document.querySelectorAll("input[name=layer]").forEach((one) => { one.checked = one.value === state.layer; });
  showEvidence();
  trying(showParameters, { keep: true });
}

// Search

function endSearch() {
  searching?.abort();
  searching = null;
  player?.pause();
  player = null;
  episode = null;
  by("player").hidden = by("say-box").hidden = true;
  delete by("player").dataset.ended;
  by("stop").hidden = true;
  by("search-state").textContent = "";
  by("search-state").classList.remove("found");
  by("episode").disabled = true;
  view?.setDrone([], null, []);
}

/** The outcome is told once it is shown, not as soon as it is known. */
function searched(at) {
  view.setFrames([]);
  const last = player?.ended && at === player.steps.length - 1;
  by("search-state").classList.toggle("found", Boolean(last && player.ended.found));
  by("search-state").textContent = !last ? `Step ${at}` : player.ended.found ? `Found after ${at} steps` : `Not found in ${at} steps`;
}

/** The belief of each target, as a player shows it before the first step. */
const believed = () => Object.fromEntries((shown.belief?.targets ?? []).map((one) => [one.id, { ...one.belief, hpd90: one.hpd90 }]));

function openPlayer(places, pose, beliefs) {
  by("player").hidden = false;
  player = new Player(by("player"), view, { announce, shown: searched });
  player.begin(places, pose, beliefs, state.target);
  view.setArea(state.polygon ?? state.area);
  if (by("map-a").getBoundingClientRect().bottom > innerHeight) by("maps").scrollIntoView({ block: "start" });
}

/** Play an episode that was kept in a file; nothing more can be said in it. */
function playFile(kept) {
  endSearch();
  openPlayer(kept.places, kept.pose, kept.beliefs ?? believed());
  kept.steps.forEach((step) => player.add(step));
  player.end(kept);
  episode = kept;
  by("episode").disabled = false;
  by("player").dataset.ended = kept.steps.length;
  player.play();
}

async function search(sayings = {}, from = 0) {
  // What is said later on must not move a place that was imagined.
  const places = from && episode ? episode.places : state.places;
  endSearch();
  const mine = (searching = new AbortController());
  state.sayings = sayings;
  remember();
  by("stop").hidden = false;
  by("search-state").textContent = "The drone is thinking …";
  const before = believed();
  const known = Object.fromEntries(Object.entries(places).filter(([name]) => name in before));
  await trying(async () => {
    const response = await post("/api/search", {
      state: asked(), planner: state.planner, places: known, start: state.start, seed: state.seed,
      steps: state.steps, range_cells: state.range, utterances: Object.entries(sayings).map(([step, text]) => [Number(step), text]),
    }, mine.signal);
    const steps = [];
    for await (const event of events(response)) {
      if (event.kind === "error") throw new Error(event.error);
      if (event.kind === "start") {
        openPlayer(event.places, event.pose, before);
        by("say-box").hidden = false;
        if (!from) player.play();
        episode = { places: event.places, pose: event.pose, steps };
      } else if (event.kind === "step") {
        steps.push(event);
        player.add(event);
        if (from && steps.length === from) { player.show(from); player.play(); }
      } else if (event.kind === "end") {
        Object.assign(episode, { found: event.found, episode: event.episode });
        player.end(episode);
        by("episode").disabled = false;
        by("player").dataset.ended = steps.length;
      }
    }
  });
  if (searching === mine) by("stop").hidden = true;
}

// Map

async function showMap() {
  working(true);
  scene = await get(`/api/map/${encodeURIComponent(state.map)}`);
  by("map-a").replaceChildren(by("caption-a"));
  by("map-b").replaceChildren(by("caption-b"));
  other = null;
  view = new CityView(by("map-a"), scene, start.colours, {
    pick: (at) => use(view.tool, at),
    area: (area) => change(Array.isArray(area[0]) ? { area: null, polygon: area } : { area, polygon: null }),
    corner: cornerSet,
    hover: readout,
    cell: say,
    key: (event) => {
      const tool = KEYS[event.key.toLowerCase()];
      if (!tool || view.cursor == null) return false;
      if (tool !== "polygon") view.dropCorners(view.corners.length);
      use(tool, view.centreOf(view.cursor));
      return true;
    },
  });
  view.root.setAttribute("aria-label", `Map of ${scene.name}: arrow keys move, Enter uses the tool`);
  by("attribution").textContent = scene.attribution;
  chooseTool(document.querySelector("input[name=tool]:checked")?.value ?? "look");
}

function chooseTool(tool) {
  view.tool = tool;
  view.dropCorners(view.corners.length);
  corner = null;
  by("map-a").dataset.tool = tool;
}

async function takeFile(file) {
  if (!file) return;
  by("file").value = ""; // so that the same file can be opened once more
  noted(`Reading ${file.name} …`);
  const opened = await trying(async () => {
    const played = await episodeIn(file);
    await (played ? openEpisode(played) : openMap(file));
    return true;
  });
  if (!opened) noted("");
}

function noted(text) {
  by("map-note").textContent = text;
  by("map-note").hidden = !text;
}

/** Send a file to the server, which reads it. */
async function read(path, file) {
  const name = file.name.replace(/\.[a-z.0-9]+$/i, "");
  const response = await fetch(`${path}?name=${encodeURIComponent(name)}`, { method: "POST", body: file, headers: { "Content-Type": "application/octet-stream" } });
  const found = await response.json();
  if (!response.ok) throw new Refused(response.status, found.error);
  return { ...found, file: name };
}

async function openMap(file) {
  const found = await read("/api/maps", file);
  options(by("map"), found.maps.map((m) => [m.key, m.name]), found.key);
  await startWith({ map: found.key });
  noted(found.note || `${found.file} is open. It stays on this machine.`);
  by("text").focus();
}

/** Whether a file is an episode, by what is in it: maps are JSON too. */
async function episodeIn(file) {
  if (!/\.json$/i.test(file.name) || file.size > MOST_EPISODE_BYTES) return null;
  try {
    const content = JSON.parse(await file.text());
    return Array.isArray(content.poses) || content.format === "sloop_ppl episode" ? file : null;
  } catch { return null; }
}

async function openEpisode(file) {
  const found = await read("/api/episode", file);
  const { places, pose } = found.search;
  const text = found.text || (found.map === state.map ? state.text : "");
  await startWith({ map: found.map, model: found.model, text, places, start: pose.slice(0, 2), target: Object.keys(places)[0] ?? "" });
  noted(`${found.file} is open. ${found.note}`);
  playFile(found.search);
}

/** Show another map or sentence as one step that can be undone. */
async function startWith(given) {
  undone.push(JSON.stringify(state));
  const moved = state.map !== given.map;
  state = { ...BLANK, ...given };
  by("text").value = state.text;
  if (moved) await showMap();
  await update();
}

// Files

async function keepPage() {
  const [style, module, template] = await Promise.all(["style.css", "view.js", "page.html"].map(async (name) => (await fetch(`/static/${name}`)).text()));
  const data = { scene, colours: start.colours, text: state.text, belief: shown.belief, frames, search: episode?.episode ? episode : null };
  const parts = { title: `${scene.name} - sloop_ppl`, style, module: module.replaceAll("</", "<\\/"), data: JSON.stringify(data).replaceAll("<", "\\u003c") };
  const page = template.replace(/\{\{(\w+)\}\}/g, (_, name) => name === "title" ? parts.title.replace(/[<&>]/g, "") : parts[name]);
  download(page, "sloop.html", "text/html");
}

async function keep(kind) {
  const response = await post(`/api/export/${kind}`, asked());
  const name = /filename="([^"]+)"/.exec(response.headers.get("content-disposition"))[1];
  download(await response.blob(), name);
}

// Begin

async function begin() {
  theme();
  start = await get("/api/start").catch((error) => {
    problem(error.message);
    throw error;
  });
  const { first } = start;
  state = { ...BLANK, map: first.map, text: first.text, places: first.places, ...(fromAddress() ?? {}) };
  if (fromAddress()) state.places = fromAddress().places ?? {};
  options(by("map"), start.maps.map((m) => [m.key, m.name]), state.map);
  options(by("model"), start.models.map((m) => [m, m]));
  options(by("compare"), [["", "no other"], ...start.models.map((m) => [m, m])]);
  options(by("frames"), [["", "the model's own"], ...start.frames.map((m) => [m, m])]);
  options(by("prior"), [["", "anywhere alike"], ...start.priors.map((m) => [m, m])]);
  options(by("planner"), start.planners.map((m) => [m, m]));
  options(by("example"), [["", "choose one"], ...first.examples.map((e, i) => [String(i), `${e.map}: ${e.text}`])]);
  by("tools").replaceChildren(...Object.entries(TOOLS).map(([key, text]) => radio("tool", key, text, "look", chooseTool, "", TOOL_TITLES[key])));
  by("layers").replaceChildren(...Object.entries(LAYERS).map(([key, text]) => radio("layer", key, text, state.layer, (layer) => {
    state.layer = layer;
    remember();
    showMaps();
  })));
  by("text").value = state.text;
  wire();
  await trying(showMap);
  await update();
  document.body.dataset.ready = "true";
}

function wire() {
  let typing = null, typed = 0;
  by("text").addEventListener("input", () => {
    const text = by("text").value;
    if (Date.now() - typed > 1000) undone.push(JSON.stringify(state)); // a burst of typing is one step
    typed = Date.now();
    state = { ...state, text, off: [], answers: [] };
    showReading(null);
    working(true);
    clearTimeout(typing);
    typing = setTimeout(update, 25);
  });
  by("text").addEventListener("scroll", () => { by("marks").scrollTop = by("text").scrollTop; });
  for (const name of ["compare", "viewpoint"]) by(name).addEventListener("change", () => change({ [name]: by(name).value }));
  // Another model has other numbers.
  for (const name of ["model", "variant"]) by(name).addEventListener("change", () => change({ [name]: by(name).value, parameters: {} }));
  by("reset").addEventListener("click", () => change({ parameters: {} }));
  by("model-box").addEventListener("toggle", () => trying(showParameters));
  for (const name of ["frames", "prior"]) by(name).addEventListener("change", () => change({ [name]: by(name).value || null }));
  by("planner").addEventListener("change", () => change({ planner: by("planner").value }));
  for (const name of ["range", "steps", "seed"]) {
    by(name).addEventListener("change", () => { if (by(name).reportValidity()) change({ [name]: Number(by(name).value) }); });
  }
  by("map").addEventListener("change", () => {
    const map = by("map").value, example = start.first.examples.find((e) => e.map === map);
    noted("");
    trying(() => startWith({ model: state.model, map, text: example?.text ?? "", places: example?.places ?? {} }));
  });
  by("example").addEventListener("change", () => {
    const { map, text, places } = start.first.examples[Number(by("example").value)] ?? {};
    by("example").value = "";
    if (map) trying(() => startWith({ model: state.model, map, text, places }));
  });
  by("file").addEventListener("change", () => takeFile(by("file").files[0]));
  document.addEventListener("dragover", (event) => { event.preventDefault(); document.body.classList.add("dropping"); });
  document.addEventListener("dragleave", (event) => { if (!event.relatedTarget) document.body.classList.remove("dropping"); });
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("dropping");
    takeFile(event.dataTransfer.files[0]);
  });
  by("undo").addEventListener("click", undo);
  document.addEventListener("keydown", (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z" && !event.shiftKey && !event.target.matches("input[type=text], textarea")) {
      event.preventDefault();
      undo();
    }
  });
  by("search").addEventListener("click", () => search());
  by("stop").addEventListener("click", () => { searching?.abort(); by("stop").hidden = true; player?.pause(); });
  by("say-box").addEventListener("submit", (event) => {
    event.preventDefault();
    const words = by("say").value.trim();
    if (!words || !player) return;
    const at = player.at;
    by("say").value = "";
    const earlier = Object.fromEntries(Object.entries(state.sayings).filter(([step]) => Number(step) < at));
    search({ ...earlier, [at]: words }, at);
  });
  by("questions-box").addEventListener("toggle", () => { if (by("questions-box").open) trying(() => questions()); });
  by("why-box").addEventListener("toggle", () => { if (by("why-box").open) trying(() => why()); });
  by("link").addEventListener("click", async () => {
    await navigator.clipboard.writeText(location.href).catch(() => {});
    announce("The link is copied.");
    by("link").textContent = "Copied";
    setTimeout(() => { by("link").textContent = "Copy link"; }, 1500);
  });
  document.querySelectorAll("[data-export]").forEach((button) => button.addEventListener("click", () => trying(() => keep(button.dataset.export))));
  by("episode").addEventListener("click", () => download(JSON.stringify({ text: state.text, ...episode.episode }), "episode.json", "application/json"));
  by("page").addEventListener("click", () => trying(keepPage));
  document.addEventListener("theme", () => { view?.repaint(); other?.repaint(); });
  addEventListener("pagehide", () => searching?.abort());
  addEventListener("hashchange", async () => {
    const given = fromAddress();
    if (!given) return;
    const map = state.map;
    state = { ...BLANK, map, ...given };
    by("text").value = state.text;
    if (state.map !== map) await trying(showMap);
    await update();
  });
}

begin();
