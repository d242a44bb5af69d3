// The search box: ranks the entries of search_index.js, parts of guides and names of the reference.
"use strict";
(() => {
  const root = document.documentElement.dataset.root;
  const box = document.getElementById("talus-search"), list = document.getElementById("talus-results");
  const words = (text) => (text.toLowerCase().match(/[\p{L}\p{N}_]+/gu) || []);
  const stem = (word) => word.length > 3 ? word.replace(/(ies)$/, "y").replace(/([^s])s$/, "$1") : word;
  let entries = null, documents = null;

  // Once, at the first use: the words of each entry, and how many entries have a word.
  function prepare() {
    if (entries) return;
    documents = new Map();
    const pages = new Map();
    entries = window.SEARCH_INDEX.map((e) => {
      const counts = new Map();
      const text = words(`${e.h} ${e.t}`).flatMap((w) => w.includes("_") ? [w, ...w.split("_")] : [w]).map(stem);
      for (const w of text) if (w) counts.set(w, (counts.get(w) || 0) + 1);
      for (const w of counts.keys()) documents.set(w, (documents.get(w) || 0) + 1);
      // Words of the whole page: a guide that says a word again and again, for its length, is about it.
      if (!pages.has(e.p)) pages.set(e.p, new Map());
      const page = pages.get(e.p);
      for (const [w, n] of counts) page.set(w, (page.get(w) || 0) + n);
      page.size_of_text = (page.size_of_text || 0) + text.length;
      return {...e, counts, page, size: text.length, title: words(e.p).map(stem), heading: words(e.h).map(stem)};
    });
  }

  // How often a word is in an entry; the beginning of a longer word counts less.
  function count(e, word) {
    const exact = e.counts.get(word) || 0;
    if (exact || word.length < 3) return exact;
    for (const [w, n] of e.counts) if (w.startsWith(word)) return 0.3 * n;
    return 0;
  }

  function score(e, query, asked) {
    let sum = 0;
    for (const word of asked) {
      const n = count(e, word);
      if (n === 0 && !(e.k === "guide" && e.title.includes(word))) return 0;  // all words have to be there
      const rare = Math.log(1 + entries.length / (1 + (documents.get(word) || 0)));
      sum += rare * n / (n + 0.6 + 0.6 * e.size / 120);  // Robertson's BM25
      if (e.heading.includes(word)) sum += 1.5 * rare;
      const often = e.k === "guide" ? 1000 * (e.page.get(word) || 0) / (e.page.size_of_text + 300) : 0;
      sum += rare * often / (often + 8);
      if (e.k === "guide" && e.title.includes(word)) sum += (e.h === e.p ? 1.5 : 0.7) * rare;
    }
    const phrase = asked.join(" ");
    if (asked.length > 1) {
      if (e.heading.join(" ").includes(phrase)) sum *= 1.7;
      if (e.k === "guide" && e.title.join(" ").includes(phrase)) sum *= 1.5;
    }
    sum *= e.w;
    const name = e.h.toLowerCase(), last = name.split("::").pop();
    if (e.k === "guide") return sum;
    // A name that was typed is the first result; other names come after the guides.
    if (name === query || (query.includes("_") && last === query)) return 1000 + (e.k === "member" ? 0 : 100);
    return query.includes("_") ? sum : 0.15 * sum;
  }

  function find(query) {
    prepare();
    query = query.trim().toLowerCase().replace(/^talus::/, "").replace(/\(\)$/, "");
    const asked = words(query).map((w) => w.includes("_") ? w : stem(w));
    if (!asked.length) return [];
    const plainWord = !/[_:]/.test(query);
    return entries.map((e) => ({e, score: score(e, query, asked)})).filter((r) => r.score > 0)
      // A common word, such as "restitution", is looked for in the guides first.
      .map((r) => plainWord && r.e.k !== "guide" && r.score >= 1000 ? {...r, score: r.score - 1000 + 5} : r)
      .sort((a, b) => b.score - a.score).slice(0, 30);
  }

  const escaped = (text) => text.replace(/[&<>"]/g, (c) => ({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;"})[c]);
  function excerpt(text, asked) {
    const at = Math.max(0, Math.min(...asked.map((w) => {
      const i = text.toLowerCase().indexOf(w);
      return i < 0 ? Infinity : i;
    }).concat([text.length])) - 50);
    const from = at >= text.length - 50 ? 0 : at;
    let part = escaped((from > 0 ? "…" : "") + text.slice(from, from + 150) + (text.length > from + 150 ? "…" : ""));
    for (const w of asked) part = part.replace(new RegExp(`(${w.replace(/[^\p{L}\p{N}_]/gu, "")})`, "gi"), "<mark>$1</mark>");
    return part;
  }

  function show() {
    const query = box.value, asked = words(query).map(stem);
    const found = find(query);
    list.hidden = !query.trim();
    list.innerHTML = found.length === 0 ? "<p>Nothing found.</p>" : found.map(({e}) => {
      const guide = e.k === "guide";
      const name = guide ? (e.h === e.p ? escaped(e.p) : `${escaped(e.p)} › ${escaped(e.h)}`) : `<code>${escaped(e.h)}</code>`;
      return `<a href="${root}${escaped(e.u)}" data-kind="${e.k}"><strong>${name}</strong> <small>${guide ? "guide" : escaped(e.k)}` +
        `</small><span>${excerpt(e.t, asked)}</span></a>`;
    }).join("");
  }

  box.addEventListener("input", show);
  box.addEventListener("focus", () => { if (box.value) show(); });
  document.addEventListener("click", (event) => { if (!event.target.closest(".search")) list.hidden = true; });
  box.form.addEventListener("submit", (event) => {
    event.preventDefault();
    const first = list.querySelector("a");
    if (first) location.href = first.href;
  });
  document.addEventListener("keydown", (event) => {
    const links = [...list.querySelectorAll("a")], at = links.indexOf(document.activeElement);
    if (event.key === "/" && !/^(input|textarea)$/i.test(document.activeElement.tagName)) {
      event.preventDefault(), box.focus(), box.select();
    } else if (event.key === "Escape") {
      list.hidden = true;
    } else if (!list.hidden && (event.key === "ArrowDown" || event.key === "ArrowUp")) {
      event.preventDefault();
      const next = at + (event.key === "ArrowDown" ? 1 : -1);
      (next < 0 ? box : links[Math.min(next, links.length - 1)])?.focus();
    }
  });
  list.addEventListener("click", () => { list.hidden = true; });
  window.talusSearch = (query) => find(query).map(({e, score}) => ({kind: e.k, page: e.p, heading: e.h, address: e.u, score}));
  const asked = new URLSearchParams(location.search).get("q");
  if (asked) box.value = asked, show();
})();
