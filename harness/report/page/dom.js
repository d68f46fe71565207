// Elements. Text gets into the page here and only as text: there is no way to markup.

// What has no property of the same name.
const attributes = new Set(["role", "for", "tabindex"]);

// An element with properties and children (elements or texts; null and undefined are left out).
// `on…` properties are listeners, `class` and `data` what they say.
export function el(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === null || value === undefined) continue;
    if (name === "class") element.className = value;
    else if (name === "data") Object.assign(element.dataset, value);
    else if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name.includes("-") || attributes.has(name)) element.setAttribute(name, value);
    else element[name] = value;
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

// Gives `element` new children.
export function fill(element, ...children) {
  element.replaceChildren(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

export function byId(id) {
  return document.getElementById(id);
}

// Buttons of which one is pressed: `choices` are [value, label]; `chosen(value)` tells of a click.
export function choice(label, choices, value, chosen) {
  const buttons = choices.map(([own, text]) =>
    el("button", {type: "button", "aria-pressed": String(own === value), data: {value: own},
                  onclick: () => { press(own); chosen(own); }}, text));
  const press = (own) => buttons.forEach((button) =>
    button.setAttribute("aria-pressed", String(button.dataset.value === String(own))));
  const group = el("span", {class: "group", role: "group", "aria-label": label}, buttons);
  group.press = press;
  return group;
}

// A labelled drop-down list.
export function dropDown(label, choices, value, chosen) {
  const select = el("select", {onchange: () => chosen(select.value)},
    choices.map(([own, text]) => el("option", {value: own, selected: own === value}, text)));
  return el("label", {}, el("span", {class: "soft small"}, label), select);
}

// A button that puts what `text()` gives onto the clipboard and says so.
export function copyButton(text, label = "Copy") {
  const button = el("button", {type: "button", onclick: async () => {
    button.textContent = (await copied(text())) ? "Copied" : "Select and copy it by hand";
    setTimeout(() => { button.textContent = label; }, 2000);
  }}, label);
  return button;
}

async function copied(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    // Without the clipboard's permission: through a selection.
    const area = el("textarea", {value: text, class: "offscreen"});
    document.body.append(area);
    area.select();
    const done = document.execCommand("copy");
    area.remove();
    return done;
  }
}

// Gives the reader a file.
export function download(name, type, text) {
  const url = URL.createObjectURL(new Blob([text], {type}));
  el("a", {href: url, download: name}).click();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}
