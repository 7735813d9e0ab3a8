// How far a study is, and what its descriptions say: relations are corrected here.
import { html } from "./view.js";
import { announce, ask, by, get, options, problem, theme, trying } from "./page.js";

let progress;

async function load() {
  progress = await get("/api/collect/progress");
  const { configurations, people, answers } = progress;
  const done = configurations.filter((one) => one.people >= people).length;
  by("file").textContent = progress.file;
  by("summary").textContent = `${answers.length} descriptions; ${done} of ${configurations.length} configurations have been described by ${people} people.`;
  by("configurations").replaceChildren(...configurations.map((one) => {
    const share = html("span", { class: "share" });
    share.style.setProperty("--p", one.people / people);
    return html("li", {}, html("span", {}, one.id), share, html("span", { class: "small" }, `${one.people} of ${people}`));
  }));
  showAnswers();
}

function showAnswers() {
  const shown = progress.answers.filter((one) => !by("only").checked || !one.checked);
  by("answers").replaceChildren(...shown.map(card));
  if (!shown.length) by("answers").append(html("p", { class: "small" }, progress.answers.length ? "Everything is checked." : "Nothing has been described yet."));
}

function card(one) {
  const rows = html("tbody", {});
  const add = (entry) => rows.append(row(one, entry));
  one.relations.forEach(add);
  const table = html("table", {}, html("thead", {}, html("tr", {}, ...["object", "relation", "place", "denied", ""].map((t) => html("th", { scope: "col" }, t)))), rows);
  const status = html("span", { class: `small ${one.checked ? "checked" : ""}` }, one.checked ? "checked" : "not checked");
  return html("section", { class: "answer", "data-id": one.id },
    html("h3", {}, one.id, " ", status), html("p", { class: "said" }, `“${one.text}”`), html("div", { class: "scroll" }, table),
    html("p", { class: "row wrap" },
      html("button", { type: "button", onclick: () => add({ figure: Object.keys(one.targets)[0], relation: "near", ground: progress.grounds[one.map][0].id }) }, "Add a relation"),
      html("button", { type: "button", class: "primary", onclick: () => check(one, rows) }, "Save as checked")));
}

function row(one, entry) {
  const choice = (label, entries, chosen) => {
    const select = html("select", { "aria-label": label });
    options(select, entries, chosen);
    return html("td", {}, select);
  };
  const node = html("tr", {},
    choice("object", Object.keys(one.targets).map((t) => [t, t]), entry.figure),
    choice("relation", progress.words.map((w) => [w, w]), entry.relation),
    choice("place", progress.grounds[one.map].map((g) => [g.id, g.label]), entry.ground),
    html("td", {}, html("input", { type: "checkbox", "aria-label": "denied", checked: Boolean(entry.negated) })),
    html("td", {}, html("button", { type: "button", "aria-label": "Remove this relation", onclick: () => node.remove() }, "Remove")));
  node.dataset.group = entry.group ?? "";
  return node;
}

async function check(one, rows) {
  const relations = [...rows.children].map((node) => {
    const [figure, relation, ground] = [...node.querySelectorAll("select")].map((select) => select.value);
    const group = node.dataset.group === "" ? null : Number(node.dataset.group);
    return { figure, relation, ground, negated: node.querySelector("input").checked, group };
  });
  await trying(async () => {
    await ask("/api/collect/corrections", { id: one.id, relations });
    await load();
    announce(`${one.id} is checked.`);
  });
}

async function begin() {
  theme();
  await load().catch((error) => { problem(error.message); throw error; });
  by("only").addEventListener("change", showAnswers);
  document.body.dataset.ready = "true";
}

begin();
