// @ts-check
/** Where a value stands in a text. */
export const PLACE = /\{(\w+)\}/g;
