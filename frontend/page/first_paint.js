// Runs before the first paint, so that the page does not flash in the wrong theme.
for (const what of ["theme", "text"]) {
  try {
    const value = localStorage.getItem(`brickpose.${what}`);
    if (value) document.documentElement.dataset[what] = value;
  } catch {
    // Storage is switched off: use the system's setting.
  }
}
