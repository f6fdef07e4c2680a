// @ts-check

/**
 * Return the page's element with this id, which must be of the given class.
 * @template {Element} T
 * @param {string} id
 * @param {{new (...args: any[]): T}} kind
 * @returns {T}
 */
export function find(id, kind) {
  const element = document.getElementById(id);
  if (element instanceof kind) return element;
  throw new Error(`The page has no ${kind.name} #${id}.`);
}

/** @param {string} id */
export const findButton = (id) => find(id, HTMLButtonElement);

/** @param {string} id */
export const findInput = (id) => find(id, HTMLInputElement);

/**
 * Write a text only if it changed: setting the same text again costs layout.
 * @param {Element} element
 * @param {string} text
 */
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/**
 * @param {string} tag
 * @param {Record<string, string>} attributes
 * @param {...(Node | string)} children
 */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}
