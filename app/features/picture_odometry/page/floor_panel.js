// @ts-check
// The floor before the robot from above, and what it says of the wheels.

/** Time between two pictures [ms]. */
const PERIOD_MS = 200;

const GERMAN = document.documentElement.lang === "de";

/** @type {Record<string, string>} */
const WORDS = GERMAN
  ? {
      unknown: "am Boden ist nichts zu sehen",
      rolling: "die Räder rollen",
      stuck: "steckt fest",
      slipping: "die Räder rutschen",
      pushed: "wird geschoben",
      lifted: "hochgehoben",
    }
  : {
      unknown: "nothing to see on the floor",
      rolling: "the wheels roll",
      stuck: "stuck",
      slipping: "the wheels slip",
      pushed: "pushed",
      lifted: "lifted",
    };

const OFF = GERMAN
  ? "Bewegung wird nicht in Bildern gemessen; [picture_odometry] enabled schaltet das ein."
  : "Motion is not measured in pictures; [picture_odometry] enabled turns that on.";

/**
 * @param {HTMLElement} body
 * @returns {{show: (telemetry: {values?: Record<string, unknown> | null}) => void}}
 */
export function panel(body) {
  const picture = document.createElement("img");
  picture.alt = GERMAN ? "Boden von oben" : "Floor from above";
  picture.style.width = "100%";
  const words = document.createElement("p");
  body.append(picture, words);
  const section = body.closest("section");
  const phone = matchMedia("(max-width: 640px), (max-height: 500px)");
  let last = 0;
  let loading = false;
  let off = false;
  // Where it shares a tab it takes room of the map's only if there is something to see.
  const fit = () => {
    if (section) section.style.display = off && phone.matches ? "none" : "";
  };
  phone.addEventListener("change", fit);
  picture.onload = picture.onerror = () => {
    loading = false;
  };
  return {
    show({ values }) {
      const state = String(values?.wheels ?? "");
      const speed = values?.floor_speed_mm_s;
      const fast = typeof speed === "number" ? `, ${speed} mm/s` : "";
      picture.hidden = !state;
      off = !state;
      fit();
      words.textContent = state ? `${WORDS[state] ?? state}${fast}` : OFF;
      const now = performance.now();
      if (state && !loading && picture.offsetParent !== null && now - last >= PERIOD_MS) {
        loading = true;
        last = now;
        picture.src = `floor.jpg?${Math.round(now)}`;
      }
    },
  };
}
