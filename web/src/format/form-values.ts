/** What stands in a form. */

/** The text of a field, without blanks around it; empty where there is none. */
export function formText(said: FormData, name: string): string {
  const value = said.get(name);
  return typeof value === "string" ? value.trim() : "";
}
