// Runs before the first paint, so that a chosen theme does not flash in the other one.
for (const what of ["theme", "text"]) {
  try {
    const value = localStorage.getItem(`brickpose.${what}`);
    if (value) document.documentElement.dataset[what] = value;
  } catch {
    // Storage is switched off: the system's setting holds.
  }
}
