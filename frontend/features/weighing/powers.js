// @ts-check
const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/** Ten to a power that is rounded to a whole number, as people write it. @param {number} power */
export function powerOfTen(power) {
  const digits = String(Math.abs(Math.round(power)));
  const raised = [...digits].map((digit) => RAISED[Number(digit)]).join("");
  return `10${Math.round(power) < 0 ? "⁻" : ""}${raised}`;
}
