// Light or dark: the system's choice until the reader makes one.
import {el} from "./dom.js";

let chosen = (() => {
  try { return localStorage.getItem("penumbra-theme"); } catch { return null; }
})();

const systemIsDark = matchMedia("(prefers-color-scheme: dark)");
const listeners = [];

// As page.css has the colours.
function apply() {
  document.documentElement.dataset.theme = chosen ?? (systemIsDark.matches ? "dark" : "light");
}
apply();

export function isDark() {
  return document.documentElement.dataset.theme === "dark";
}

// A colour of page.css as it is now.
export function cssColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

// Canvases do not follow style sheets: `draw` is called when the colours have changed.
export function onThemeChange(draw) {
  listeners.push(draw);
}

export function themeButton() {
  const label = () => (isDark() ? "Light" : "Dark");
  const changed = () => {
    apply();
    button.textContent = label();
    listeners.forEach((draw) => draw());
  };
  const button = el("button", {type: "button", id: "theme", onclick: () => {
    chosen = isDark() ? "light" : "dark";
    try { localStorage.setItem("penumbra-theme", chosen); } catch { /* a reader who keeps nothing */ }
    changed();
  }}, label());
  systemIsDark.addEventListener("change", changed);
  return button;
}
