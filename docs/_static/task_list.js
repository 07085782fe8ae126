/* The filter above the list of tasks: words, set, number of variations and tier. The page is whole without it. */
"use strict";

const table = document.querySelector("table.task-list");
if (table !== null) {
  const rows = Array.from(table.tBodies[0].rows, (row) => ({
    row,
    text: `${row.cells[0].textContent} ${row.cells[1].textContent}`.toLowerCase(),
    variations: Number(row.cells[2].textContent),
    tier: row.cells[3].textContent.trim(),
    sets: Array.from(row.cells[4].querySelectorAll("code"), (code) => code.textContent),
  }));
  const ranges = { "1 variation": [1, 1], "2 to 9": [2, 9], "10 to 19": [10, 19], "20 or more": [20, Infinity] };
  const names = Array.from(new Set(rows.flatMap((each) => each.sets))).sort();

  const words = document.createElement("input");
  words.type = "search";
  words.placeholder = "Name or sentence";
  words.ariaLabel = words.placeholder;
  const choice = (title, options) => {
    const select = document.createElement("select");
    select.ariaLabel = title;
    select.append(new Option(title, ""), ...options.map((option) => new Option(option, option)));
    return select;
  };
  const set = choice("All sets", names);
  const variations = choice("Any number of variations", Object.keys(ranges));
  const tier = choice("All tiers", ["1", "2", "3", "4"]);
  const count = document.createElement("output");
  const bar = document.createElement("form");
  bar.className = "task-filter";
  bar.append(words, set, variations, tier, count);
  (table.closest(".table-wrapper") ?? table).before(bar);

  const update = () => {
    const wanted = words.value.toLowerCase().split(/\s+/).filter(Boolean);
    const [least, most] = ranges[variations.value] ?? [0, Infinity];
    let shown = 0;
    for (const each of rows) {
      const fits = wanted.every((word) => each.text.includes(word)) && (!set.value || each.sets.includes(set.value))
        && each.variations >= least && each.variations <= most && (!tier.value || each.tier === tier.value);
      each.row.hidden = !fits;
      shown += Number(fits);
    }
    count.textContent = `${shown} of ${rows.length} tasks`;
  };
  bar.addEventListener("input", update);
  bar.addEventListener("change", update);
  bar.addEventListener("submit", (event) => event.preventDefault());
  update();
}
