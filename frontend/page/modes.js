// @ts-check
import { t } from "./language.js";

/** @type {Record<string, string>} */
const MODES = {
  idle: t("stopped"),
  drive: t("driving"),
  figure_eight: t("figure-eight"),
  calibrate: t("calibrating"),
  explore: t("exploring"),
  navigate: t("on its way"),
};

/** What the robot drives, in words. @param {string} mode as telemetry tells it */
export const modeWords = (mode) => MODES[mode] ?? mode;
