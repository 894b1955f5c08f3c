"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const at = (id) => document.getElementById(id);
  const controls = at("controls"), board = at("board");
  const TEXT = 0, SORT = 1, DETAIL = 2, BAR = 3;
  let order = { key: "rank", down: false };

  const made = (tag, className, text) => {
    const element = document.createElement(tag);
    if (className) element.className = className;
    if (text !== undefined) element.textContent = text;
    return element;
  };
  const table = () => data[at("plants").value + "|" + at("circles").value];

  function sorted(lines, column) {
    const value = (line) => line[4][column][SORT] ?? null;
    const compared = (a, b) => (typeof a === "string" ? a.localeCompare(b) : a - b) * (order.down ? -1 : 1);
    return [...lines].sort((a, b) => {
      const x = value(a), y = value(b);
      if (x === null || y === null) return (x === null) - (y === null); // what has no figure goes last, either way
      return compared(x, y);
    });
  }

  function matches([kind, name, track, learned, cells, knowledge, channel]) {
    const words = at("search").value.trim().toLowerCase().split(/\s+/);
    const text = (name + " " + track + " " + channel + " " + knowledge + " " + kind + " " + cells.map((cell) => cell[TEXT] + " " + (cell[DETAIL] ?? "")).join(" ")).toLowerCase();
    return (!at("track").value || at("track").value === track) && (!at("channel").value || at("channel").value === channel) && (!at("knowledge").value || at("knowledge").value === knowledge) && (at("learning").value === "" || Number(at("learning").value) === learned) && words.every((word) => text.includes(word));
  }

  function heading([key, title, unit, isText]) {
    const th = made("th", key + (isText ? " l" : "")), button = made("button", "", title);
    th.scope = "col";
    if (order.key === key) th.setAttribute("aria-sort", order.down ? "descending" : "ascending");
    if (unit) button.append(" ", made("span", "unit", "[" + unit + "]"));
    button.type = "button";
    button.dataset.key = key;
    th.append(button);
    return th;
  }

  function cell([kind, name], [key, , , isText], values) {
    const element = made(key === "agent" ? "th" : "td", key + (isText ? " l" : ""));
    if (key === "agent") element.scope = "row";
    const linked = key === "agent" && kind !== "published";
    const value = made(linked ? "a" : "span", linked ? "" : "value", values[TEXT]);
    if (linked) value.href = "#agent-" + encodeURIComponent(name);
    element.append(value);
    if (values[DETAIL]) element.append(" ", made("span", "detail", values[DETAIL]));
    if (values[BAR] !== undefined) {
      const bar = made("span", "bar"), filled = made("span");
      filled.style.width = 100 * values[BAR] + "%";
      bar.append(filled);
      element.append(bar);
    }
    return element;
  }

  function show() {
    const { columns, lines, note } = table();
    if (!columns.some(([key]) => key === order.key)) order = { key: "rank", down: false };
    const shown = sorted(lines.filter(matches), columns.findIndex(([key]) => key === order.key));
    const head = made("tr");
    head.append(...columns.map(heading));
    board.tHead.replaceChildren(head);
    board.tBodies[0].replaceChildren(...shown.map((line) => {
      const row = made("tr", line[0]);
      row.append(...columns.map((column, k) => cell(line, column, line[4][k])));
      return row;
    }));
    at("note").textContent = note;
    at("count").textContent = shown.length + " of " + lines.length + " rows";
  }

  function openCard() {
    const named = (card) => "#" + encodeURIComponent(card.id) === location.hash;
    const card = [...document.querySelectorAll("details.card")].find(named);
    if (!card) return;
    card.open = true;
    card.scrollIntoView();
    card.querySelector("summary").focus({ preventScroll: true });
  }

  board.tHead.addEventListener("click", (event) => {
    const button = event.target.closest("button");
    if (!button) return;
    const key = button.dataset.key;
    order = { key, down: order.key === key && !order.down };
    show();
    board.tHead.querySelector('button[data-key="' + CSS.escape(key) + '"]').focus();
  });
  for (const kind of ["input", "change"]) controls.addEventListener(kind, show);
  controls.addEventListener("submit", (event) => event.preventDefault());
  controls.addEventListener("reset", () => { order = { key: "rank", down: false }; setTimeout(show); });
  document.addEventListener("click", (event) => {
    const link = event.target.closest('a[href^="#agent-"]');
    if (!link || event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault(); // the browser would take the focus away again, and do nothing the second time
    history.pushState(null, "", link.getAttribute("href"));
    openCard();
  });
  addEventListener("hashchange", openCard);
  controls.hidden = false;
  show();
  openCard();
})();
