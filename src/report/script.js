// Makes a report's page easier to use. Without it, all is there: pictures side by side, tables in their order.
(() => {
  "use strict";
  const all = (what, within = document) => [...within.querySelectorAll(what)];
  document.documentElement.classList.add("js");

  // A cell's number: `1.80 MB` is 1800000, what is no number comes last.
  const SCALE = { n: 1e-9, "\u00b5": 1e-6, m: 1e-3, k: 1e3, M: 1e6, G: 1e9, T: 1e12, P: 1e15 };
  const number = (text) => {
    const found = /^([+\u2212\u00b1-]?)([\d,]*\.?\d+)\s*(?:([n\u00b5mkMGTP])(?:i?B|J|\b))?/.exec(text.trim());
    if (!found) return NaN;
    const value = Number(found[2].replaceAll(",", "")) * (SCALE[found[3]] || 1);
    return found[1] === "\u2212" || found[1] === "-" ? -value : value;
  };
  const compare = (a, b) => {
    const [x, y] = [number(a), number(b)];
    if (Number.isNaN(x) || Number.isNaN(y)) return Number.isNaN(x) - Number.isNaN(y) || a.localeCompare(b);
    return x - y;
  };
  for (const table of all("table.sort")) {
    const body = table.tBodies[0];
    const heads = all("thead th", table);
    if (body.rows.length < 2) continue;
    heads.forEach((head, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...head.childNodes);
      head.append(button);
      head.setAttribute("aria-sort", "none");
      button.addEventListener("click", () => {
        const down = head.getAttribute("aria-sort") === "ascending";
        heads.forEach((other) => other.setAttribute("aria-sort", "none"));
        head.setAttribute("aria-sort", down ? "descending" : "ascending");
        const text = (row) => row.cells[column].textContent;
        const rows = [...body.rows].sort((a, b) => compare(text(a), text(b)) * (down ? -1 : 1));
        body.append(...rows);
      });
    });
  }

  // Reference and policy, one over the other up to a cut.
  for (const figure of all(".compare")) {
    const cut = figure.querySelector("input");
    const move = () => figure.style.setProperty("--cut", `${cut.value}%`);
    cut.addEventListener("input", move);
    move();
  }

  // One slider for all plots over frames, for the pictures and for the figures of a frame.
  const bar = document.querySelector(".frames");
  const rows = all("tr[data-frame]");
  if (bar && rows.length) {
    const [slider, shown, list] = ["input", "output", "dl"].map((what) => bar.querySelector(what));
    const policy = bar.querySelector("select");
    const numbers = rows.map((row) => Number(row.dataset.frame));
    const heads = all("thead th", rows[0].closest("table")).map((head) => head.textContent);
    const draw = (svg, what, attributes) => {
      const it = document.createElementNS("http://www.w3.org/2000/svg", what);
      Object.entries(attributes).forEach(([name, value]) => it.setAttribute(name, value));
      svg.append(it);
      return it;
    };
    // Where a plot is clicked on, that frame is chosen.
    const clicked = (svg, frameAt) => svg.addEventListener("click", (event) => {
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      const frame = frameAt(at);
      if (frame === undefined) return;
      const far = numbers.map((number) => Math.abs(number - frame));
      slider.value = far.indexOf(Math.min(...far));
      choose();
    });
    const plots = all("svg[data-frames]").map((svg) => {
      const axis = svg.dataset.frames.split(" ").map(Number);
      const [first, last, from, to] = axis;
      clicked(svg, ({ x }) => (x < from || x > to ? undefined : first + ((x - from) / (to - from)) * (last - first)));
      const line = draw(svg, "line", { class: "cursor", y1: 0, y2: svg.viewBox.baseVal.height });
      return { line, axis };
    });
    // In strips of time a frame has a stretch a policy.
    const strips = all("svg[data-strips]").flatMap((svg) => {
      const found = svg.dataset.strips.match(/\d+( \d+){4}/g).map((it) => it.split(" ").map(Number));
      clicked(svg, ({ x, y }) => (found.find(([, left, top, right, bottom]) => (
        x >= left && x <= right && y >= top && y <= bottom)) || [])[0]);
      return found.map(([frame, x, y, right, bottom]) => (
        { frame, box: draw(svg, "rect", { class: "cursor", x, y, width: right - x, height: bottom - y }) }));
    });
    const pictures = all(".compare");
    const choose = () => {
      const frame = numbers[slider.value];
      shown.textContent = `frame ${frame}`;
      slider.setAttribute("aria-valuetext", `frame ${frame}`);
      for (const { line, axis: [first, last, from, to] } of plots) {
        const x = from + ((frame - first) / (last - first)) * (to - from);
        line.setAttribute("x1", x);
        line.setAttribute("x2", x);
      }
      strips.forEach((it) => it.box.toggleAttribute("data-hidden", it.frame !== frame));
      const row = rows.find((it) => Number(it.dataset.frame) === frame);
      list.replaceChildren(...[...row.cells].slice(1).map((cell, index) => {
        const [pair, name, value] = ["div", "dt", "dd"].map((what) => document.createElement(what));
        name.textContent = `${heads[index + 1]} `;
        value.textContent = cell.textContent;
        pair.append(name, value);
        return pair;
      }));
      // Pictures are there of some frames only: those of the nearest one are shown.
      const far = (figure) => Math.abs(Number(figure.dataset.frame) - frame);
      const of = pictures.filter((figure) => !policy || figure.dataset.policy === policy.value);
      const near = of.reduce((best, next) => (best && far(best) <= far(next) ? best : next), undefined);
      pictures.forEach((figure) => figure.toggleAttribute("data-hidden", figure !== near));
    };
    numbers.sort((a, b) => a - b);
    slider.max = numbers.length - 1;
    slider.value = numbers.indexOf(Number(bar.dataset.first));
    slider.addEventListener("input", choose);
    policy?.addEventListener("change", choose);
    bar.hidden = false;
    choose();
  }

  // Paper has no folds: what is an appendix is open there.
  const folded = all("details.appendix");
  addEventListener("beforeprint", () => folded.forEach((it) => { it.open = true; }));
})();
