// @ts-check
/**
 * Colours for canvases, from the same custom properties as the page's colours.
 * Roles: truth, odometry, estimate, rays. Colours with "floor" are for the picture of the floor,
 * which is light in both themes.
 */
const NAMES = /** @type {const} */ ([
  "text",
  "quiet",
  "line",
  "panel",
  "accent",
  "warning",
  "truth",
  "odometry",
  "estimate",
  "rays",
  "then",
  "floor-truth",
  "floor-odometry",
  "floor-estimate",
  "floor-rays",
  "floor-then",
  "floor-hits",
  "floor-drawn",
  "floor-draft",
  "floor-grid",
  "floor-halo",
  "floor-light",
  "floor-beam",
]);

/** @typedef {typeof NAMES[number]} ColourName */
/** @typedef {Record<ColourName, string> & {font: string, fontSize: number}} Palette */

/** @type {Palette} */
export const palette = /** @type {Palette} */ ({});

/** Read the colours and the text size again after the theme changed. */
export function refreshPalette() {
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) palette[name] = style.getPropertyValue(`--${name}`).trim();
  palette.fontSize = parseFloat(style.getPropertyValue("--tiny")) * parseFloat(style.fontSize);
  palette.font = `${palette.fontSize}px system-ui, sans-serif`;
}
