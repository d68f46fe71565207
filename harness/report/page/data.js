// The data that the page was written with: elements that the browser neither shows nor runs.

// The text of a data element; null while the page has not been read so far, or if there is none.
export function pageText(id) {
  return document.getElementById(id)?.textContent ?? null;
}

// A JSON element; null if there is none.
export function pageData(id) {
  const text = pageText(id);
  return text === null ? null : JSON.parse(text);
}

// The bytes of a base64 element; waits for the page to be read if it is not there yet.
export async function pageBytes(id) {
  let text = pageText(id);
  if (text === null && document.readyState === "loading") {
    await new Promise((done) => document.addEventListener("DOMContentLoaded", done, {once: true}));
    text = pageText(id);
  }
  if (text === null) throw new Error(`the page holds no ${id}`);
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = characters.charCodeAt(i);
  return bytes;
}
