// Runs before the first paint, so that the page does not flash in the wrong theme.
// The cookie has the token by now: the address, which people share, need not show it.
if (new URLSearchParams(location.search).has("token")) {
  history.replaceState(null, "", location.pathname + location.hash);
}
for (const what of ["theme", "text", "more"]) {
  try {
    const value = localStorage.getItem(`brickpose.${what}`);
    if (value) document.documentElement.dataset[what] = value;
  } catch {
    // Storage is switched off: use the system's setting.
  }
}
