/** What stands in a form. */

/** The text of a field, without blanks around it; empty where there is none. */
export function formText(said: FormData, name: string): string {
  const value = said.get(name);
  return typeof value === "string" ? value.trim() : "";
}

/** What was sent with a form's `submit`, which the page handles itself; undefined where no form was. */
export function submittedForm(event: Event): FormData | undefined {
  event.preventDefault();
  return event.currentTarget instanceof HTMLFormElement ? new FormData(event.currentTarget) : undefined;
}
