"use strict";
(() => {
  const KEY = "symgen-theme", NAMES = ["auto", "light", "dark"], root = document.documentElement;
  const stored = () => { try { return localStorage.getItem(KEY); } catch { return null; } };
  const store = (name) => { try { localStorage.setItem(KEY, name); } catch { /* pages from files may keep nothing */ } };
  let now = NAMES.includes(stored()) ? stored() : "auto";
  const show = () => {
    if (now === "auto") delete root.dataset.theme; else root.dataset.theme = now;
    const button = document.getElementById("theme");
    if (!button) return;
    button.hidden = false;
    button.querySelector("output").textContent = now;
  };
  show();
  document.addEventListener("DOMContentLoaded", () => {
    show();
    document.getElementById("theme")?.addEventListener("click", () => {
      now = NAMES[(NAMES.indexOf(now) + 1) % NAMES.length];
      store(now);
      show();
    });
  });
})();
