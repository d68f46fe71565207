// Tables that sort by a click on a header, filter by words and can be taken away as CSV.
import {download, el, fill} from "./dom.js";

const csvField = (value) => {
  const text = value === null || value === undefined ? "" : String(value);
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
};

export function csvText(columns, rows) {
  const lines = [columns.map(({name}) => name), ...rows.map((row) => columns.map(({value}) => value(row)))];
  return `${lines.map((line) => line.map(csvField).join(",")).join("\r\n")}\r\n`;
}

// Texts by letters, numbers by size; what is not there comes last either way.
function compare(a, b, sign) {
  const aMissing = a === null || a === undefined || a === "", bMissing = b === null || b === undefined || b === "";
  if (aMissing || bMissing) return aMissing - bMissing;
  if (typeof a === "number" && typeof b === "number") return sign * (a - b);
  return sign * String(a).localeCompare(String(b), "en", {numeric: true});
}

// A column: name (of the CSV too), title (of the header), value(row), show(row) (text or element;
// the value if absent), number (aligned right), doc (what it means).
// Options: name (of the file), sort ({column, descending}), filter, changed({sort, filter}),
// most (rows drawn before a button asks for all).
export function dataTable(columns, rows, options = {}) {
  let {sort = null, filter = ""} = options;
  let most = options.most ?? 200;
  const told = () => options.changed?.({sort, filter});
  // Columns of long texts get room, or they would be as narrow as their longest word.
  const kinds = columns.map((column) => (column.number ? "number"
    : rows.some((row) => String(column.value(row) ?? "").length > 40) ? "long" : ""));
  const headers = columns.map((column, i) => el("th",
    {scope: "col", class: kinds[i], title: column.doc},
    el("button", {type: "button", data: {column: column.name}, onclick: () => {
      const descending = sort?.column === column.name ? !sort.descending : Boolean(column.largeFirst);
      sort = {column: column.name, descending};
      draw();
      told();
    }}, column.title ?? column.name)));
  const body = el("tbody");
  const counted = el("span", {class: "soft small", "aria-live": "polite"});
  const more = el("button", {type: "button", onclick: () => { most = Infinity; draw(); }}, "Show all");
  const search = el("input", {type: "search", placeholder: "Filter…", value: filter, "aria-label": "Filter rows",
    oninput: () => { filter = search.value; draw(); told(); }});

  const haystacks = new Map(rows.map((row) =>
    [row, columns.map((column) => String(column.value(row) ?? "")).join("\n").toLowerCase()]));
  function chosen() {
    const words = filter.toLowerCase().split(/\s+/).filter(Boolean);
    const left = rows.filter((row) => words.every((word) => haystacks.get(row).includes(word)));
    const column = columns.find(({name}) => name === sort?.column);
    if (column) left.sort((a, b) => compare(column.value(a), column.value(b), sort.descending ? -1 : 1));
    return left;
  }
  function draw() {
    const left = chosen();
    headers.forEach((header, i) => header.setAttribute("aria-sort",
      sort?.column !== columns[i].name ? "none" : sort.descending ? "descending" : "ascending"));
    fill(body, left.slice(0, most).map((row) => el("tr", {class: options.rowClass?.(row)}, columns.map((column, i) =>
      el("td", {class: kinds[i]},
         column.show ? column.show(row) : String(column.value(row) ?? ""))))));
    counted.textContent = left.length === rows.length ? `${rows.length} rows` : `${left.length} of ${rows.length} rows`;
    more.hidden = left.length <= most;
  }
  draw();
  return el("div", {class: "data-table"},
    el("div", {class: "row spread table-tools"}, el("span", {class: "row"}, search, counted),
       el("button", {type: "button", class: "csv", onclick: () =>
         download(`${options.name ?? "table"}.csv`, "text/csv", csvText(columns, chosen()))}, "Download CSV")),
    el("div", {class: "scroll", tabindex: "0", role: "region", "aria-label": options.name ?? "table"},
       el("table", {}, el("thead", {}, el("tr", {}, headers)), body)),
    more);
}
