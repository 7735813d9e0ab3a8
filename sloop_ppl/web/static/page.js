// What the pages share: requests, what is announced, the theme.
import { html } from "./view.js";

export class Refused extends Error {
  constructor(status, message) { super(message); this.status = status; }
}

async function answer(response) {
  if (response.ok) return response;
  let message = `${response.status}`;
  try { message = (await response.json()).error ?? message; } catch { /* no JSON: its number is all there is */ }
  throw new Refused(response.status, message);
}

export async function get(path) { return (await answer(await fetch(path))).json(); }

export async function post(path, body, signal) {
  const headers = { "Content-Type": "application/json" };
  return answer(await fetch(path, { method: "POST", headers, body: JSON.stringify(body), signal }));
}

export const ask = async (path, body, signal) => (await post(path, body, signal)).json();

/** The events of a server-sent stream. */
export async function* events(response) {
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  let rest = "";
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    const parts = (rest + value).split("\n\n");
    rest = parts.pop();
    for (const part of parts) if (part.startsWith("data: ")) yield JSON.parse(part.slice(6));
  }
}

export const by = (id) => document.getElementById(id);

let spoken;
/** Say something to those who listen to the page; said again only if it is new. */
export function announce(text) {
  clearTimeout(spoken);
  spoken = setTimeout(() => { if (by("live").textContent !== text) by("live").textContent = text; }, 250);
}

export function problem(text) {
  by("problem").textContent = text ?? "";
  by("problem").hidden = !text;
}

/** Run something; what goes wrong is shown in one line, in place of what went wrong before. */
export async function trying(work, { keep = false } = {}) {
  try {
    if (!keep) problem("");
    return await work();
  } catch (error) {
    if (error.name !== "AbortError") problem(error instanceof Refused ? error.message : `This did not work: ${error.message}`);
    return undefined;
  }
}

export function options(select, entries, chosen) {
  select.replaceChildren(...entries.map(([value, text]) => html("option", { value, selected: value === chosen }, text)));
  if (chosen !== undefined) select.value = chosen;
}

export function download(content, name, type = "application/octet-stream") {
  const url = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type }));
  html("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** Light, dark, or as the system is. */
export function theme() {
  const kept = localStorage.getItem("sloop-theme");
  const set = (name) => {
    if (name) document.documentElement.dataset.theme = name;
    else delete document.documentElement.dataset.theme;
  };
  set(kept);
  const button = by("theme");
  const label = () => {
    const dark = document.documentElement.dataset.theme
      ? document.documentElement.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    button.textContent = dark ? "Light" : "Dark";
    button.setAttribute("aria-label", `Change to ${dark ? "light" : "dark"} colours`);
    return dark;
  };
  label();
  button.addEventListener("click", () => {
    const name = label() ? "light" : "dark";
    set(name);
    localStorage.setItem("sloop-theme", name);
    label();
    document.dispatchEvent(new Event("theme"));
  });
}
