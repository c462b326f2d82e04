/** In which language the pages are: a choice of this browser, that loads them anew. */

import { msg } from "@lit/localize";
import { html, LitElement, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { base } from "../base/base-style.js";
import { shownLanguage } from "../../words/locale.js";
import { chooseLanguage, languageName, LANGUAGES } from "../../words/language.js";
import { renderOptions } from "./form-parts.js";
import "./field.js";

@customElement("t-language-choice")
export class LanguageChoice extends LitElement {
  static override styles = base;

  override render(): TemplateResult {
    return html`<t-field label=${msg("Language")}>
      <select name="language" @change=${this.onChange}>
        ${renderOptions(
          LANGUAGES.map((code) => [code, languageName(code)]),
          shownLanguage(),
        )}
      </select>
    </t-field>`;
  }

  private readonly onChange = (event: Event): void => {
    chooseLanguage((event.target as HTMLSelectElement).value);
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-language-choice": LanguageChoice;
  }
}
