/** A question as a page asks it: `t-confirm` with the words for what it is about. */

import { msg } from "@lit/localize";
import { html, type TemplateResult } from "lit";
import type { QuestionController } from "../../controllers/question.js";
import type { Advice } from "../../format/error-advice.js";
import type { ButtonKind } from "../forms/button.js";
import "./confirm.js";

interface QuestionWords {
  readonly heading: string;
  /** Of the button that says yes: what is done, as a verb. */
  readonly action: string;
  readonly keep?: string;
  readonly kind?: ButtonKind;
  /** What will happen: a sentence, or more than that. */
  readonly text: unknown;
  /** What is wrong besides a failure of the action. */
  readonly problem?: Advice | null;
}

const NO_WORDS: QuestionWords = { heading: "", action: "", text: "" };

/** Closed it stays on the page: a dialog that is taken away gives no focus back. */
export function renderQuestion<T>(question: QuestionController<T>, words: (subject: T) => QuestionWords): TemplateResult {
  const { subject, action } = question;
  const { heading, action: verb, keep = msg("Cancel"), kind = "danger", text, problem = null } = subject === null ? NO_WORDS : words(subject);
  return html`<t-confirm
    heading=${heading}
    action=${verb}
    keep=${keep}
    .kind=${kind}
    ?open=${question.isOpen}
    ?busy=${action.busy}
    .problem=${action.problem ?? problem}
    @t-confirm=${question.confirm}
    @t-close=${question.close}
    >${typeof text === "string" ? html`<p>${text}</p>` : text}</t-confirm
  >`;
}
