// Light or dark: the system's choice until the reader makes one.
import {el} from "./dom.js";

const stored = () => {
  try { return localStorage.getItem("penumbra-theme"); } catch { return null; }
};

const systemIsDark = matchMedia("(prefers-color-scheme: dark)");
const listeners = [];

export function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : systemIsDark.matches;
}

// A colour of page.css as it is now.
export function cssColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

// Canvases do not follow style sheets: `draw` is called when the colours have changed.
export function onThemeChange(draw) {
  listeners.push(draw);
}

// The button; it also brings back what the reader chose before.
export function themeButton() {
  if (stored()) document.documentElement.dataset.theme = stored();
  const label = () => (isDark() ? "Light" : "Dark");
  const changed = () => {
    button.textContent = label();
    listeners.forEach((draw) => draw());
  };
  const button = el("button", {type: "button", id: "theme", onclick: () => {
    const theme = isDark() ? "light" : "dark";
    document.documentElement.dataset.theme = theme;
    try { localStorage.setItem("penumbra-theme", theme); } catch { /* a reader who keeps nothing */ }
    changed();
  }}, label());
  systemIsDark.addEventListener("change", changed);
  return button;
}
