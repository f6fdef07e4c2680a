// @ts-check
import { t } from "../page/language.js";

/** @typedef {import("./lease.js").Ended} Ended */

/** Say which drive has ended, and by what. @param {Ended} ended */
export const endedWords = ({ programme, why }) => t("{drive} ended: {reason}.", { drive: driveWords(programme), reason: reasonWords(why) });

/** @param {Ended["programme"]} programme */
function driveWords(programme) {
  switch (programme) {
    case "calibrate":
      return t("The drive that calibrates");
    case "explore":
      return t("Exploring");
    case "navigate":
      return t("The drive to the goal");
    default:
      return t("The figure-eight");
  }
}

/** @param {Ended["why"]} why */
function reasonWords(why) {
  switch (why) {
    case "hidden":
      return t("this page was hidden");
    case "away":
      return t("this page or the network paused for too long");
    case "taken":
      return t("somebody else drives");
    default:
      return t("somebody stopped the robot");
  }
}
