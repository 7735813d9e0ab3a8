// Collecting descriptions: two objects on a map, and what a person says of where they are.
import { CityView, html, svg } from "./view.js";
import { announce, ask, by, get, problem, theme, trying } from "./page.js";

const COLOURS = { green: "#009e73", red: "#d55e00", blue: "#0072b2" };
let person = localStorage.getItem("sloop-person"), task, view, hinting;

async function next(skipped = null) {
  const found = await ask("/api/collect/guest/next", { person, skipped });
  by("example").hidden = true;
  task = found;
  if (!found.configuration) {
    by("task").hidden = true;
    by("done").hidden = false;
    by("thanks").textContent = `There is no map left for you. You have described ${found.described}.`;
    return;
  }
  by("task").hidden = false;
  by("task").classList.add("workbench");
  const scene = await get(`/api/map/${encodeURIComponent(found.map)}`);
  by("map-a").replaceChildren();
  view = new CityView(by("map-a"), scene, {});
  view.root.setAttribute("aria-label", `Map of ${scene.name} with ${found.objects.map((o) => o.name).join(" and ")}`);
  view.root.setAttribute("tabindex", "-1");
  by("attribution").textContent = scene.attribution;
  const draw = () => view.layers.marks.replaceChildren(...found.objects.map((one) => marker(one, view.metresPerPixel ?? 0.3)));
  draw();
  new ResizeObserver(draw).observe(view.root);
  by("objects").replaceChildren(...found.objects.map((one) => html("li", {}, swatch(one), html("b", {}, one.name))));
  by("text").value = by("second").value = "";
  by("hint").replaceChildren();
  by("count").textContent = found.described ? `You have described ${found.described} so far.` : "";
  by("text").focus();
  announce(`A map of ${scene.name} with ${found.objects.map((o) => o.name).join(" and ")}.`);
}

const colour = (one) => COLOURS[one.name.split(" ")[1]] ?? "#0072b2";
const isBike = (one) => /bike/i.test(one.id);
const CAR = "M-9 3V-1L-5 -2L-3 -6H4L7 -2L9 -1V3H7A2.2 2.2 0 0 1 2.6 3H-2.6A2.2 2.2 0 0 1 -7 3Z";
const BIKE = "M-6 3m-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0M6 3m-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0M-6 3L-2 -4H4L6 3M-2 -4L1 3H-6M4 -4L1 3M-4 -4H0M3 -6H5";

function marker(one, px) {
  const [x, y] = one.at;
  const node = svg("g", { class: "object", transform: `translate(${x} ${-y}) scale(${1.3 * px})`, "data-object": one.id });
  node.append(svg("circle", { r: 15 }), svg("path", { d: isBike(one) ? BIKE : CAR, class: isBike(one) ? "drawn" : "" }));
  node.style.setProperty("--colour", colour(one));
  return node;
}

function swatch(one) {
  const root = svg("svg", { viewBox: "-17 -17 34 34", width: 34, height: 34, "aria-hidden": "true" });
  const node = marker({ ...one, at: [0, 0] }, 1 / 1.3);
  root.append(node);
  return root;
}

async function hint() {
  const text = by("text").value, mine = task.configuration;
  if (!text.trim()) return by("hint").replaceChildren();
  const found = await ask("/api/collect/guest/read", { configuration: mine, text });
  if (mine !== task.configuration || text !== by("text").value) return;
  by("hint").replaceChildren(...(found.phrases.length
    ? [html("p", {}, "Understood so far:"), html("ul", {}, ...found.phrases.map((p) => html("li", {}, p)))]
    : [html("p", {}, "Nothing of this was understood as a place yet. You may save it all the same.")]),
    found.phrases.length && found.missing.length ? html("p", {}, `Nothing yet about ${found.missing.join(" and ")}.`) : null ?? "");
}

async function save() {
  const texts = [by("text").value, by("second").value].map((t) => t.trim()).filter(Boolean);
  if (!texts.length) {
    problem("Write something first, or skip this map.");
    by("text").focus();
    return;
  }
  await trying(async () => {
    await ask("/api/collect/guest/descriptions", { person, configuration: task.configuration, texts, consent: true });
    await next();
  });
}

async function begin() {
  theme();
  get("/api/start").then(() => { by("pages").hidden = false; }).catch(() => { /* invited people see this page only */ });
  by("consent").addEventListener("change", () => { by("begin").disabled = !by("consent").checked; });
  by("begin").addEventListener("click", async () => {
    try {
      if (!person) {
        person = (await ask("/api/collect/guest/join", {})).person;
        localStorage.setItem("sloop-person", person);
      }
      await next();
    } catch (error) {
      by("problem-first").textContent = error.message;
      by("problem-first").hidden = false;
    }
  });
  by("text").addEventListener("input", () => {
    clearTimeout(hinting);
    hinting = setTimeout(() => trying(hint), 200);
  });
  by("save").addEventListener("click", save);
  by("skip").addEventListener("click", () => trying(() => next(task.configuration)));
  document.body.dataset.ready = "true";
}

begin();
