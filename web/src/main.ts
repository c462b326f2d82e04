/** The language first: the pages have words in constants, too. */

import { msg } from "@lit/localize";
import { startLanguage } from "./words/language.js";

/** Of a hub that went away between the first lines of the pages and all others: else the window would stay empty. */
function sayMissing(): void {
  const said = document.createElement("p");
  said.role = "alert";
  said.textContent = msg("The hub does not answer, so the pages cannot be loaded.");
  const again = document.createElement("button");
  again.textContent = msg("Try again");
  again.addEventListener("click", () => {
    location.reload();
  });
  document.querySelector("t-app")?.append(said, again);
}

startLanguage()
  .then(() => import("./pages/shell/app.js"))
  .catch(sayMissing);
