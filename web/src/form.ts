// Two-way binding of the state to the form's elements, by their names.

import type { State } from "./state";

type Field = HTMLInputElement | HTMLSelectElement;

export class Form {
  private readonly fields: Field[];

  constructor(
    private readonly form: HTMLFormElement,
    onChange: (change: Partial<State>) => void,
  ) {
    this.fields = [...form.querySelectorAll<Field>("[name]")];
    form.addEventListener("input", (event) => {
      const field = event.target as Field;
      if (field.name && !field.dataset.mode) onChange({ [field.name]: valueOf(field) });
    });
    form.addEventListener("submit", (event) => event.preventDefault());
  }

  /** Show a state, and only the controls that have a say in it. */
  show(state: State): void {
    const values = state as unknown as Record<string, unknown>;
    for (const field of this.fields) {
      if (!(field.name in values)) continue;
      const value = values[field.name];
      if (field instanceof HTMLInputElement && field.type === "radio") {
        field.checked = field.value === value;
      } else if (field instanceof HTMLInputElement && field.type === "checkbox") {
        field.checked = value === true;
      } else if (field.value !== String(value)) {
        field.value = String(value);
      }
      const output = this.form.querySelector<HTMLOutputElement>(`output[for="${field.id}"]`);
      if (output) output.value = readable(field, value);
    }
    for (const element of this.form.querySelectorAll<HTMLElement>("[data-light]")) {
      element.hidden = element.dataset.light !== state.light;
    }
  }
}

function valueOf(field: Field): string | number | boolean {
  if (field instanceof HTMLInputElement && field.type === "checkbox") return field.checked;
  return field instanceof HTMLInputElement && field.type === "range" ? Number(field.value) : field.value;
}

function readable(field: Field, value: unknown): string {
  const [, decimals = ""] = field instanceof HTMLInputElement ? field.step.split(".") : [];
  const digits = decimals.length;
  return `${Number(value).toFixed(digits)}${field.dataset.unit ?? ""}`;
}
