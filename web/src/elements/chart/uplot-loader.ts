/** uPlot with its style, in a chunk of its own: fetched when the first chart comes into view. */

import UPlot from "uplot";
import css from "uplot/dist/uPlot.min.css?inline";

/** A constructed sheet: the hub's content policy allows no style elements. */
export const sheet = new CSSStyleSheet();
sheet.replaceSync(css);

export { UPlot };
