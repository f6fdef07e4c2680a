// @ts-check
import { find, findButton } from "../../page/elements.js";
import { offerLanguages } from "../../page/language.js";
import { Appearance } from "../../page/theme.js";

new Appearance(findButton("theme"), findButton("large-text"));
offerLanguages(find("language", HTMLSelectElement));
document.title = `${document.querySelector("h1")?.textContent} – BrickPose`;
