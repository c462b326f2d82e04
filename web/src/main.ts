/** The language first: the pages have words in constants, too. */

import { startLanguage } from "./words/language.js";

void startLanguage().then(() => import("./pages/shell/app.js"));
