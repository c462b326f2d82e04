/** The language first: the pages have words in constants, too. */

import { startLanguage } from "./state/language.js";

void startLanguage().then(() => import("./pages/shell/app.js"));
