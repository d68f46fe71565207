// What is being looked at, in the URL's hash, so that any view can be linked.

const listeners = [];

// An object of texts.
export function state() {
  return Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
}

// The hash of a view; entries that are null or empty are left out.
export function linkTo(view) {
  const entries = Object.entries(view).filter(([, value]) => value !== null && value !== undefined && value !== "");
  return `#${new URLSearchParams(entries)}`;
}

// Another page: a step in the browser's history.
export function go(view) {
  location.hash = linkTo(view).slice(1);
}

// A detail of the same page: no step, no redrawing.
export function keep(changes) {
  history.replaceState(null, "", linkTo({...state(), ...changes}));
}

// Filter and order of the page's table in the hash; `sort` is the column where it says none.
export const remembered = (view, sort = null) => ({filter: view.filter ?? "",
  sort: view.sort ? {column: view.sort, descending: view.down === "1"} : sort && {column: sort, descending: false},
  changed: ({sort: order, filter}) => keep({sort: order?.column, down: order?.descending ? "1" : "", filter})});

export function onGo(draw) {
  listeners.push(draw);
}

addEventListener("hashchange", () => listeners.forEach((draw) => draw(state())));
