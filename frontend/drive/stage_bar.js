// @ts-check
import { findButton } from "../page/elements.js";

/** Large buttons where the drive panel is not shown, as for a projector: each presses that of another panel. */
export function offerStageBar() {
  for (const button of document.querySelectorAll("button[data-press]")) {
    if (!(button instanceof HTMLButtonElement)) continue;
    const pressed = findButton(button.dataset.press ?? "");
    const follow = () => {
      button.disabled = pressed.disabled;
      const state = pressed.getAttribute("aria-pressed");
      if (state !== null) button.setAttribute("aria-pressed", state);
    };
    button.title = pressed.title;
    button.onclick = () => pressed.click();
    new MutationObserver(follow).observe(pressed, { attributes: true, attributeFilter: ["aria-pressed", "disabled"] });
    follow();
  }
}
