// The page without a hub: asks for it until it answers, and opens then what was asked for.
const FIRST_MS = 1000;
const LONGEST_MS = 8000;
const root = document.documentElement;
const told = document.getElementById("tries");
let wait = FIRST_MS;
let timer = 0;

try {
  const theme = localStorage.getItem("talaia.theme");
  if (theme !== null && theme !== "auto") root.setAttribute("data-theme", theme);
} catch {
  // A browser that keeps nothing goes by its own colours.
}

async function askHub() {
  clearTimeout(timer);
  try {
    // HEAD: the worker leaves it alone, so that only the hub itself can answer.
    const answer = await fetch(location.pathname, { method: "HEAD", cache: "no-store", credentials: "omit" });
    if (answer.ok) {
      told.textContent = "The hub answers. Opening…";
      if (location.pathname === "/offline.html") location.replace("/");
      else location.reload();
      return;
    }
    told.textContent = `Something on the way to the hub answers with ${String(answer.status)}. It is tried again by itself.`;
  } catch {
    told.textContent = `Tried at ${new Date().toLocaleTimeString(undefined, { hour12: false })}. It is tried again by itself.`;
  }
  wait = Math.min(LONGEST_MS, wait * 2);
  timer = setTimeout(askHub, wait);
}

function askNow() {
  wait = FIRST_MS;
  void askHub();
}

document.getElementById("again").addEventListener("click", askNow);
window.addEventListener("online", askNow);
// A phone that wakes up gets no timer for what it slept through.
document.addEventListener("visibilitychange", () => {
  if (document.visibilityState === "visible") askNow();
});
timer = setTimeout(askHub, wait);
