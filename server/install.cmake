# What is installed beside the program: its page, samples, man page and shell completions. The last are
# written by the program from its own tree of commands.
foreach(page IN ITEMS "man isochor.1" "bash-completion isochor.bash" "zsh-completion isochor.zsh")
  separate_arguments(page)
  list(GET page 0 what)
  list(GET page 1 file)
  add_custom_command(OUTPUT ${file} COMMAND isochor generate ${what} > ${file} DEPENDS isochor VERBATIM)
  list(APPEND generated ${CMAKE_CURRENT_BINARY_DIR}/${file})
endforeach()
add_custom_target(isochor_pages ALL DEPENDS ${generated})

install(TARGETS isochor RUNTIME)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/isochor.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/isochor.bash
  DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME isochor)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/isochor.zsh
  DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions RENAME _isochor)
set(web ${PROJECT_SOURCE_DIR}/web)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/samples DESTINATION ${CMAKE_INSTALL_DATADIR}/isochor PATTERN "*.py" EXCLUDE)
install(DIRECTORY ${web}/bundle ${web}/report DESTINATION ${CMAKE_INSTALL_DATADIR}/isochor/web)
